#pragma once

#include <Eigen/Core>
#include <optional>

#include "patch_surface.h"

namespace dn::internal {

struct RegisterOptions {
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();  ///< of the patch in a
  double radius_m = 0.0;
  double reach_m = 0.0;  ///< a point has a partner no further away than this
};

/// How a patch of strip a lies in strip b.
struct Registration {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< a + shift = b
  double rms_m = 0.0;                                 ///< weighted, of the distances from planes
  double used_share = 0.0;                            ///< of the points: weight above one half
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();   ///< sum of w n n^T, both directions
  /// Covariance of the shift as if all distances were independent, rms^2 normal^-1.
  Eigen::Matrix3d independent_m2 = Eigen::Matrix3d::Zero();
  /// By the scatter of what the parts of the patch want: distances within a part may be correlated.
  Eigen::Matrix3d clustered_m2 = Eigen::Matrix3d::Zero();
};

/// The shift that brings two patches together: least sum of squared distances of the points of each
/// from the planes of the other, by Tukey's weights. Rotation is not estimated: over a patch the one
/// that is left is small.
///
///   minimise  sum_a w (n_b . (a + s - c_b))^2  +  sum_b w (n_a . (b - s - c_a))^2
///
/// c, n: centroid and normal of the neighbourhood of the nearest point. The clustered covariance is
/// N^-1 (K / (K - 3) sum_k g_k g_k^T) N^-1 with g_k the sum of w n r over part k of K: White's,
/// by clusters. None where the patches have too few partners or their normals leave a direction
/// free.
std::optional<Registration> RegisterPatches(const PatchSurface& a, const PatchSurface& b,
                                            const Eigen::Vector3d& start_m,
                                            const RegisterOptions& options);

}  // namespace dn::internal
