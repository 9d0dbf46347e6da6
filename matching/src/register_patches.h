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
  /// Of the planes, as if all distances were independent: sum of w n n^T over both directions, by
  /// rms^2.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  /// Variance of what the parts of the patch want of the planes, by what it would be if all
  /// distances were independent: K / (K - 3) sum_k |g_k|^2 / (rms^2 trace(sum of w n n^T)), with g_k
  /// the sum of w n r over part k of K.
  double variance_ratio = 1.0;

  /// Covariance of the shift where the planes tell less than their information by this factor.
  Eigen::Matrix3d Covariance(double variance_factor) const {
    return variance_factor * information.inverse();
  }
};

/// The shift that brings two patches together: least sum of squared distances of the points of each
/// from the planes of the other, by Tukey's weights. Rotation is not estimated: over a patch the one
/// that is left is small.
///
///   minimise  sum_a w (n_b . (a + s - c_b))^2  +  sum_b w (n_a . (b - s - c_a))^2
///
/// c, n: centroid and normal of the neighbourhood of the nearest point, where that is a plane: its
/// rms no more than three times the median of all, within 20 deg of that of the point itself (a wall
/// that one strip sees is no partner of the roof's edge in the other).
/// None where the patches have too few partners or leave a direction free.
std::optional<Registration> RegisterPatches(const PatchSurface& a, const PatchSurface& b,
                                            const Eigen::Vector3d& start_m,
                                            const RegisterOptions& options);

}  // namespace dn::internal
