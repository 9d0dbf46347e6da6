#pragma once

#include <Eigen/Core>
#include <cmath>

namespace dn::builder_internal {

/// A laser vector u rotated toward the scan axis, and its derivatives. `toward_axis` u is the
/// derivative of u with respect to the rotation.
struct TurnedVector {
  Eigen::Vector3d u_s;
  Eigen::Matrix3d by_u;
  Eigen::Vector3d by_angle;

  TurnedVector(const Eigen::Vector3d& axis, double angle_rad, const Eigen::Vector3d& u) {
    const double height = axis.dot(u);
    const Eigen::Vector3d in_plane = u - height * axis;
    const double length = in_plane.norm();
    const Eigen::Vector3d e = in_plane / length;
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - axis * axis.transpose() - e * e.transpose();
    const Eigen::Matrix3d toward_axis =
        axis * e.transpose() - e * axis.transpose() - height / length * across;
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    by_u = c * Eigen::Matrix3d::Identity() + s * toward_axis;
    by_angle = (c * toward_axis - s * Eigen::Matrix3d::Identity()) * u;
    u_s = by_u * u;
  }
};

}  // namespace dn::builder_internal
