#pragma once

#include <dn/solvers/gauss_helmert.h>

#include <Eigen/Core>

namespace dn::internal {

/// One end of a pair at its corrected observations.
struct EndTerms {
  Eigen::Vector3d x;        ///< georeferenced point, map, m
  Eigen::Matrix3d J_theta;  ///< d x / d boresight
  Eigen::Matrix3d J_phi;    ///< d x / d attitude correction; d x / d position correction is I
};

/// The laser vector in body: by Exp(theta) = q_boresight in the exponential model, I + [theta]x
/// else.
Eigen::Vector3d BodyVector(const GaussHelmertEnd& end, BoresightModel model,
                           const Eigen::Vector3d& theta_rad, const Eigen::Quaterniond& q_boresight);

/// v_p, v_phi: corrections of the end's position and attitude.
EndTerms EvaluateEnd(const GaussHelmertEnd& end, const Eigen::Vector3d& lever_arm_b_m,
                     BoresightModel model, const Eigen::Vector3d& theta_rad,
                     const Eigen::Quaterniond& q_boresight, const Eigen::Vector3d& v_p,
                     const Eigen::Vector3d& v_phi);

/// P^-1 of an end: covariance of the position in map axes (m^2), and a factor F of that of the
/// attitude in body axes, F F^T (rad^2).
struct EndNoise {
  Eigen::Matrix3d position;
  Eigen::Matrix3d attitude_factor;
};
EndNoise EvaluateNoise(const GaussHelmertEnd& end);

}  // namespace dn::internal
