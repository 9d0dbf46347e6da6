#include <dn/factors/state_after_node.h>

namespace dn {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d StateAfterNode::PositionGravitationJacobian() const {
  return dt_s_ * dt_s_ * (step_.C.transpose() / 3.0 + Matrix3d::Identity() / 6.0);
}

Matrix3d StateAfterNode::VelocityGravitationJacobian() const {
  return 0.5 * dt_s_ * (step_.C.transpose() + Matrix3d::Identity()) -
         Skew(w_ie_m_) * PositionGravitationJacobian();
}

StateAfterNode StateAfterNode::Moved(const Eigen::Matrix<double, 9, 1>& increments,
                                     const Vector3d& gravitation_mps2) const {
  StateAfterNode out = *this;
  out.delta_q_ = delta_q_ * Exp(Vector3d(increments.head<3>()));
  out.delta_v_ += increments.segment<3>(3);
  out.delta_p_ += increments.tail<3>();
  out.step_.p_0 += PositionGravitationJacobian() * gravitation_mps2;
  out.step_.v_0 += VelocityGravitationJacobian() * gravitation_mps2;
  return out;
}

}  // namespace dn
