#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

/// What counts as a plane. Lengths scale with the distance of the points: see ForSpacing.
struct PlanarRegionOptions {
  double normal_radius_m = 0.75;   ///< neighbourhood of the normals
  double smoothness_rad = 0.0873;  ///< most between the normals of a point and of the region's seed
  double max_rms_m = 0.05;         ///< about the plane, and about that of each neighbourhood
  double min_extent_m = 3.0;       ///< of the shorter side
  /// Larger regions (ground, halls) are cut into squares of this side, in east and north.
  double max_extent_m = 15.0;
  std::size_t min_points = 30;

  /// For points spacing_m apart: neighbourhoods of three spacings and at least 0.75 m, planes of
  /// at least six spacings and 3 m, rms up to 0.05 m or a sixth of the spacing, and to 0.08 m at
  /// most: what is rougher is ground, not a roof.
  static PlanarRegionOptions ForSpacing(double spacing_m);

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// Points on a plane.
struct PlanarRegion {
  std::vector<std::size_t> points;  ///< indices, ascending
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< third component >= 0
  double rms_m = 0.0;                                 ///< about the plane, three unknowns counted
  /// Sides of the rectangle with the same second moments, shorter first, m.
  double short_side_m = 0.0, long_side_m = 0.0;
};

/// The plane that fits points best (total least squares), all of them: points stays empty. Fewer
/// than four points, or points on a line, give sides of zero.
PlanarRegion FitRegion(const std::vector<Eigen::Vector3d>& points_m);

/// Planes of a cloud by region growing (PCL): normals of the points, regions of neighbours whose
/// normals agree with that of the region's flattest point, cut to max_extent_m, each fitted by total
/// least squares with points beyond three times its rms left out, and accepted by the options. A
/// point belongs to one region at most.
///
/// points_m: in map, m; about evenly spaced (ThinByVoxel). O(n log n).
/// Throws InvalidConfig for bad options, InvalidInput for coordinates that are not finite.
std::vector<PlanarRegion> GrowPlanarRegions(const std::vector<Eigen::Vector3d>& points_m,
                                            const PlanarRegionOptions& options);

}  // namespace dn
