#pragma once

#include <Eigen/Core>

namespace dn::adjustment_internal {

/// Rotates the position of one epoch by R in a joint covariance of poses, with six rows per pose,
/// position first.
inline void RotatePosition(const Eigen::Matrix3d& R, std::size_t epoch,
                           Eigen::MatrixXd* covariance) {
  const auto at = static_cast<Eigen::Index>(6 * epoch);
  covariance->middleRows<3>(at) = R * covariance->middleRows<3>(at);
  covariance->middleCols<3>(at) = covariance->middleCols<3>(at) * R.transpose();
}

}  // namespace dn::adjustment_internal
