#pragma once

#include <dn/adjustment/pose_interpolator.h>
#include <dn/files/flight.h>
#include <dn/fixed_trajectory/gauss_helmert.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lidar_effects.h"

namespace dn::diagnosis_internal {

/// Derivatives of a georeferenced point on a fixed trajectory, from which the models of lidar
/// effects are composed. The flight must outlive the object.
class EndDerivatives {
 public:
  EndDerivatives(const Flight& flight, const Eigen::Vector3d& lever_arm_b_m,
                 const Eigen::Vector3d& boresight_rad);

  /// Returns the derivatives of W p, p the point in map, with the attitude corrected by the
  /// rotation vector v_phi_rad in body.
  PairEnd At(const GaussHelmertEnd& end, const Eigen::Vector3d& v_phi_rad,
             const Eigen::Matrix3d& W) const;

 private:
  Eigen::Vector3d PointVelocity(double t_s, const Eigen::Vector3d& s_b) const;

  Eigen::Matrix3d R_bs_nominal_;
  Eigen::Vector3d lever_arm_b_m_;
  Eigen::Quaterniond q_boresight_;
  Eigen::Matrix3d left_jacobian_;
  double first_s_, last_s_;
  PoseInterpolator poses_;
};

}  // namespace dn::diagnosis_internal
