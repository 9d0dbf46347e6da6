#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>

#include "patch_surface.h"

namespace dn::matching_internal {

/// Radius of a neighbourhood and greatest distance of partners, in distances between the points.
inline constexpr double kReach_gsd = 3.0;

/// A square of the ground.
struct GroundCell {
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();
  double half_m = 0.0;

  bool Contains(const Eigen::Vector3d& p_m) const {
    return (p_m.head<2>() - centre_en_m).cwiseAbs().maxCoeff() <= half_m;
  }
};

struct RegisterOptions {
  GroundCell cell;     ///< in strip a
  double gsd_m = 0.0;  ///< distance between the points
  /// Largest number of points of each strip that look for a partner.
  std::size_t most_points = 1000;
};

/// The shift of a patch of strip a to strip b.
struct Registration {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< a + shift = b
  /// Centre of the information of the height, in strip a. A rotation between the strips, such as
  /// that of a wrong boresight, changes the height with the place; the shift is that of this place.
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();
  /// Derivative of the score with respect to the shift.
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
  /// Covariance of the score if the differences of points are independent.
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  /// Variance of the scores of the parts of the patch, divided by the variance for independent
  /// differences: K / (K - 3) sum_k g_k^T scatter^-1 g_k / 3 with the score g_k of part k of K.
  double variance_ratio = 1.0;
  /// Shift of the patch per unit shift of the points in volumetric neighbourhoods: N^-1 N_v with
  /// the information N of all differences and N_v of the volumetric ones.
  Eigen::Matrix3d volumetric_share = Eigen::Matrix3d::Zero();
  std::size_t points = 0;  ///< in the cell, both strips
  std::size_t used = 0;    ///< points that looked for a partner

  /// Returns the covariance of the shift, J^-1 M J^-T with the stiffness J and the scatter M
  /// multiplied by this factor.
  Eigen::Matrix3d Covariance(double variance_factor) const {
    const Eigen::Matrix3d inverse = stiffness.inverse();
    return variance_factor * inverse * scatter * inverse.transpose();
  }
};

/// Finds the shift that brings two patches together. It compares the neighbourhoods of each point
/// and the nearest point of the other patch, in both directions. Rotation is not estimated, because
/// the remaining rotation of a patch is small.
///
///   score g(s) = sum_k w_k W_k d_k(s) = 0
///
/// d: the difference of the points. W: n n^T / variance along n where one of the neighbourhoods is
/// a plane with the normal n, else (C_a + C_b + s0^2 I)^-1 with the covariances of the
/// neighbourhoods. Two planes must have normals within 20 deg. A wall seen by one strip is thus not
/// matched with the edge of the roof in the other. w: weights of Student's t distribution with 4
/// degrees of freedom. The stiffness is a difference quotient with new partners: with the partners
/// kept, it would be too large.
///
/// Returns nullopt if the patches have too few partners, or the score has no stable zero near the
/// start.
std::optional<Registration> RegisterPatches(const PatchSurface& a, const PatchSurface& b,
                                            const Eigen::Vector3d& start_m,
                                            const RegisterOptions& options);

}  // namespace dn::matching_internal
