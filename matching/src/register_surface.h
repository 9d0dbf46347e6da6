#pragma once

#include <Eigen/Core>
#include <optional>

#include "patch_surface.h"
#include "register_patches.h"

namespace dn::matching_internal {

/// Least vertical component of the normal of a surface: at most 45 deg from the vertical.
inline constexpr double kLeastUp = 0.7071;

/// Returns the direction or its opposite, whichever points up.
inline Eigen::Vector3d Upward(const Eigen::Vector3d& direction) {
  return direction.z() < 0.0 ? Eigen::Vector3d(-direction) : direction;
}

/// The distance between the surfaces of a patch in two strips.
struct SurfaceRegistration {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();    ///< a + shift = b, only along the normal
  Eigen::Vector3d normal_m = Eigen::Vector3d::UnitZ();  ///< unit normal, upward
  /// Centre of the information of the height, in strip a.
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();
  double stiffness = 0.0;  ///< derivative of the score with respect to a shift along the normal
  double scatter = 0.0;    ///< variance of the score if the differences of points are independent
  /// Variance of the scores of the parts of the patch, divided by the variance for independent
  /// differences: K / (K - 1) sum_k g_k^2 / scatter.
  double variance_ratio = 1.0;

  /// Returns the variance of the distance with the scatter multiplied by this factor, m^2.
  double Variance(double variance_factor) const {
    return variance_factor * scatter / (stiffness * stiffness);
  }
};

/// Finds the distance of two smooth patches, which have no features that show a horizontal shift.
/// The score is that of RegisterPatches. The normal is the direction in which the differences have
/// the most information, N n = lambda n. The score along it does not change with a shift within the
/// surface, so that the horizontal error of the start has no effect.
///
/// Returns nullopt if the patches have too few partners, or a normal more than 45 deg from the
/// vertical. Also returns nullopt if they are not smooth: volumetric neighbourhoods then have more
/// than a tenth of the information along the normal.
std::optional<SurfaceRegistration> RegisterSurface(const PatchSurface& a, const PatchSurface& b,
                                                   const Eigen::Vector3d& start_m,
                                                   const RegisterOptions& options);

}  // namespace dn::matching_internal
