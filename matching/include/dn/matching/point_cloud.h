#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

/// Thins points to one per occupied cell of a cubic grid: the point nearest to the centre of the
/// cell.
///
/// points_m: positions in any Cartesian frame, m. voxel_m: edge of the cells, m; the grid has a
/// corner at the origin of the frame, so that strips in one frame share it. Returns indices into
/// points_m, ascending. A point closer than 1e-4 voxel_m to a face of a cell may be assigned to the
/// cell on the other side. O(n).
///
/// Throws InvalidInput if voxel_m is not positive and finite, and for a coordinate that is not
/// finite or exceeds 1e15 voxel_m (with the point).
std::vector<std::size_t> ThinByVoxel(const std::vector<Eigen::Vector3d>& points_m, double voxel_m);

/// The plane fitted to the neighbourhood of a point, in the frame of the points.
struct LocalPlane {
  std::size_t neighbours = 0;  ///< points within the radius, the point itself included
  /// Mean of the neighbourhood, m.
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  /// Unit normal, third component >= 0; zero if the neighbours define no plane.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  /// Root mean square distance to the plane, m.
  double rms_m = 0.0;
  /// (l2 - l3) / l1 of the eigenvalues l1 >= l2 >= l3 of the neighbourhood's covariance. It is 1 on
  /// a plane sampled evenly, 0 on a line or in a ball.
  double planarity = 0.0;
};

/// Fits a plane to the neighbours within radius_m of each of the points points_m[at[i]], by total
/// least squares in double precision. Fewer than three neighbours, or neighbours on a line, give no
/// plane: normal zero, planarity 0.
///
/// points_m: positions in any Cartesian frame, m, within 1e5 m of each other. The search is in
/// single precision about their mean, so a distance is good to 1e-7 of the extent. O(n log n).
///
/// Throws InvalidInput when radius_m is not positive and finite, a coordinate is not finite, or an
/// index is out of range.
std::vector<LocalPlane> FitLocalPlanes(const std::vector<Eigen::Vector3d>& points_m,
                                       const std::vector<std::size_t>& at, double radius_m);

}  // namespace dn
