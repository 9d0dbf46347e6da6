#pragma once

#include <Eigen/Core>
#include <optional>

#include "patch_surface.h"

namespace dn::matching_internal {

struct RegisterOptions {
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();  ///< centre of the patch in a
  double radius_m = 0.0;
  double reach_m = 0.0;  ///< largest distance of a point from its partner
};

/// The shift of a patch of strip a to strip b.
struct Registration {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< a + shift = b
  double rms_m = 0.0;       ///< weighted rms of the distances from the planes
  double used_share = 0.0;  ///< fraction of the points with a weight above 0.25
  /// Information matrix of the planes for independent distances: sum of w n n^T over both
  /// directions, divided by rms^2.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  /// Ratio of the variance between the parts of the patch to the variance for independent
  /// distances: K / (K - 3) sum_k |g_k|^2 / (rms^2 trace(sum of w n n^T)), where g_k is the sum of
  /// w n r over part k of K.
  double variance_ratio = 1.0;

  /// Returns the covariance of the shift with the variance of independent distances multiplied by
  /// this factor.
  Eigen::Matrix3d Covariance(double variance_factor) const {
    return variance_factor * information.inverse();
  }
};

/// Finds the shift that brings two patches together. It minimises the squared distances of the
/// points of each patch from the planes of the other with Tukey's weights. Rotation is not
/// estimated, because the remaining rotation of a patch is small.
///
///   minimise  sum_a w (n_b . (a + s - c_b))^2  +  sum_b w (n_a . (b - s - c_a))^2
///
/// c, n: centroid and normal of the neighbourhood of the nearest point. The neighbourhood must be a
/// plane: its rms is at most three times the median of all. Its normal must be within 20 deg of the
/// normal of the point itself. A wall seen by one strip is thus not matched with the edge of the
/// roof in the other. Returns nullopt if the patches have too few partners or do not determine a
/// direction.
std::optional<Registration> RegisterPatches(const PatchSurface& a, const PatchSurface& b,
                                            const Eigen::Vector3d& start_m,
                                            const RegisterOptions& options);

}  // namespace dn::matching_internal
