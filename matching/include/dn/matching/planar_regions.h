#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

/// Criteria for planes. The lengths depend on the spacing of the points: see ForSpacing.
struct PlanarRegionOptions {
  double normal_radius_m = 0.75;  ///< radius of the neighbourhood for normals
  /// Largest angle between the normals of a point and of the seed of its region.
  double smoothness_rad = 0.0873;
  double max_rms_m = 0.05;    ///< largest rms about the plane of a region and of each neighbourhood
  double min_extent_m = 3.0;  ///< least length of the shorter side
  /// Larger regions (ground, halls) are cut into squares of this side length in east and north.
  double max_extent_m = 15.0;
  std::size_t min_points = 30;

  /// Returns options for points spacing_m apart: neighbourhoods of three spacings and at least 0.75
  /// m, and planes of at least six spacings and 3 m. The largest rms is a sixth of the spacing,
  /// limited to 0.05 to 0.08 m, because rougher surfaces are ground and not roofs.
  static PlanarRegionOptions ForSpacing(double spacing_m);

  /// Throws InvalidConfig with the option, its value and its bound.
  void Validate() const;
};

/// Points on a plane, with the fitted plane.
struct PlanarRegion {
  std::vector<std::size_t> points;  ///< indices, ascending
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< third component >= 0
  double rms_m = 0.0;  ///< about the plane, with n - 3 degrees of freedom
  /// Sides of the rectangle with the same second moments, shorter first, m.
  double short_side_m = 0.0, long_side_m = 0.0;
};

/// Fits a plane to all points by total least squares; `points` of the result is empty. For fewer
/// than four points, or points on a line, the sides are zero.
PlanarRegion FitRegion(const std::vector<Eigen::Vector3d>& points_m);

/// Finds the planes of a cloud by region growing (PCL). A region consists of neighbours whose
/// normals agree with the normal of the flattest point of the region. Regions are cut to
/// max_extent_m and fitted by total least squares without points beyond three times the rms; the
/// options decide which are accepted. A point belongs to at most one region.
///
/// points_m: in map, m; about evenly spaced (ThinByVoxel). O(n log n). Throws InvalidConfig for bad
/// options, InvalidInput for coordinates that are not finite.
std::vector<PlanarRegion> GrowPlanarRegions(const std::vector<Eigen::Vector3d>& points_m,
                                            const PlanarRegionOptions& options);

}  // namespace dn
