#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// A point in body axes, q = R_mb^T (p_m - p_mb), and the laser vector that led to it.
struct PointAndVector {
  Eigen::Vector3d q_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d u_s_m = Eigen::Vector3d::Zero();
};

/// The mounting that leads from laser vectors to points.
struct MountingFit {
  Eigen::Matrix3d R_bs = Eigen::Matrix3d::Identity();       ///< scanner to body, with the boresight
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();  ///< scanner origin in body
  Eigen::Vector3d lever_arm_sigma_m = Eigen::Vector3d::Zero();
  double rms_m = 0.0;  ///< of a coordinate of the residuals
};

/// Returns the least-squares solution of q = R_bs u + a over all points. The lever arm a has a
/// prior of 0 +- 3 m, because flat ground does not show it. Returns nullopt for fewer than 30
/// points, and if the vectors lie along one line.
std::optional<MountingFit> FitMounting(const std::vector<PointAndVector>& points);

/// Returns the rotation whose columns are positive or negative unit vectors and that is nearest to
/// R: 24 are possible.
Eigen::Matrix3d NearestAxes(const Eigen::Matrix3d& R);

}  // namespace dn
