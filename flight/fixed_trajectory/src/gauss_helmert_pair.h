#pragma once

#include <dn/fixed_trajectory/gauss_helmert.h>

#include <Eigen/Core>
#include <array>

namespace dn::fixed_trajectory_internal {

/// One end of a pair at its corrected observations.
struct EndTerms {
  Eigen::Vector3d x;        ///< georeferenced point in the map frame, m
  Eigen::Matrix3d J_theta;  ///< d x / d boresight
  /// d x / d attitude correction; d x / d position correction is the identity.
  Eigen::Matrix3d J_phi;
  Eigen::Matrix3d R;  ///< corrected attitude, body -> map
};

/// Returns the laser vector u_b in the body frame, rotated by the boresight. The rotation is
/// q_boresight = Exp(theta) in the exponential model, and I + [theta]x in the small-angle model.
Eigen::Vector3d BodyVector(const Eigen::Vector3d& u_b, BoresightModel model,
                           const Eigen::Vector3d& theta_rad, const Eigen::Quaterniond& q_boresight);

/// Evaluates one end with the laser vector u_b; v_p and v_phi are the corrections of its position
/// and attitude.
EndTerms EvaluateEnd(const GaussHelmertEnd& end, const Eigen::Vector3d& u_b,
                     const Eigen::Vector3d& lever_arm_b_m, BoresightModel model,
                     const Eigen::Vector3d& theta_rad, const Eigen::Quaterniond& q_boresight,
                     const Eigen::Vector3d& v_p, const Eigen::Vector3d& v_phi);

/// d w / d laser unknowns of a pair: one column for each unknown that its ends have.
struct LaserColumns {
  static constexpr int kMost = 4;
  std::array<Eigen::Index, kMost> unknown{};
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMost> A{3, 0};

  int size() const { return static_cast<int>(A.cols()); }
  /// Adds the terms of an end with J = d w / d u_b.
  void Add(const LaserTerms& terms, const Eigen::Matrix3d& J);
};

/// Returns these columns at the boresight theta_rad and the corrections v.
LaserColumns PairLaserColumns(const GaussHelmertPair& pair, BoresightModel model,
                              const Eigen::Vector3d& theta_rad, const PairCorrection& v);

/// Observation covariance P^-1 of an end. It consists of the position covariance in map axes (m^2),
/// and of a factor F of the attitude covariance F F^T in body axes (rad^2).
struct PoseNoise {
  Eigen::Matrix3d position;
  Eigen::Matrix3d attitude_factor;
};
PoseNoise EvaluateNoise(const GaussHelmertEnd& end);

}  // namespace dn::fixed_trajectory_internal
