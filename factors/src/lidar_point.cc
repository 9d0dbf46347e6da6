#include <dn/factors/lidar_point.h>

namespace dn {

using Eigen::Matrix3d;
using Eigen::Vector3d;

LidarPoint::LidarPoint(const LocalFrame& frame, const Preintegrated& partial,
                       const Vector3d& p_nominal_m)
    : state_(frame, partial, p_nominal_m), w_b_(partial.w_end_b_radps), w_ie_m_(frame.w_ie_m()) {}

LidarPoint::Derivatives LidarPoint::DifferentiateAt(const Arguments& at) const {
  const Matrix3d R = at.q_mb.toRotationMatrix();
  const Vector3d u_b = at.q_boresight * at.u_b;
  const Vector3d l = at.a_b + u_b;
  const double ddt = at.ddt_s;
  const AffineStep& step = state_.step();
  const Vector3d &delta_v = state_.delta_v(), &delta_p = state_.delta_p();
  const Matrix3d dR = state_.delta_q().toRotationMatrix();
  const Matrix3d C_inverse_R = step.C.transpose() * R;
  const Matrix3d R_end = C_inverse_R * dR;
  const Matrix3d W = Skew(w_ie_m_);
  const Vector3d R_dp = R * delta_p;
  const Vector3d w_x_l = w_b_.cross(l);

  Derivatives out;
  out.x = step.p_p * at.p_mb + step.p_v * at.v_m + step.p_d * R_dp + step.p_0 + R_end * l;
  out.rate = step.v_p * at.p_mb + step.v_v * at.v_m + step.v_d * R_dp + C_inverse_R * delta_v +
             step.v_0 + R_end * w_x_l - w_ie_m_.cross(R_end * l);

  const Matrix3d S_dp = R * Skew(delta_p);
  const Matrix3d S_l = C_inverse_R * Skew(Vector3d(dR * l));
  const Matrix3d x_q = -step.p_d * S_dp - S_l;
  const Matrix3d rate_q =
      -step.v_d * S_dp - C_inverse_R * Skew(Vector3d(delta_v + dR * w_x_l)) + W * S_l;
  const Matrix3d l_of = R_end - ddt * (R_end * Skew(w_b_) - W * R_end);
  out.q = x_q - ddt * rate_q;
  out.p = step.p_p - ddt * step.v_p;
  out.v = step.p_v - ddt * step.v_v;
  out.theta = -l_of * Skew(u_b);
  out.a_b = l_of;
  return out;
}

Eigen::Matrix<double, 3, 9> LidarPoint::IncrementJacobian(const Arguments& at) const {
  const Matrix3d R = at.q_mb.toRotationMatrix();
  const AffineStep& step = state_.step();
  const Matrix3d C_inverse_R = step.C.transpose() * R;
  const Matrix3d R_end = C_inverse_R * state_.delta_q().toRotationMatrix();
  const Vector3d l = at.a_b + at.q_boresight * at.u_b;
  const Matrix3d S_l = R_end * Skew(l);
  const Matrix3d rate_phi = Skew(w_ie_m_) * S_l - R_end * Skew(Vector3d(w_b_.cross(l)));
  Eigen::Matrix<double, 3, 9> J;
  J << -S_l - at.ddt_s * rate_phi, -at.ddt_s * C_inverse_R, (step.p_d - at.ddt_s * step.v_d) * R;
  return J;
}

Matrix3d LidarPoint::GravitationJacobian(double ddt_s) const {
  return state_.PositionGravitationJacobian() - ddt_s * state_.VelocityGravitationJacobian();
}

LidarPoint LidarPoint::Moved(const Eigen::Matrix<double, 9, 1>& increments,
                             const Vector3d& gravitation_mps2) const {
  LidarPoint out = *this;
  out.state_ = state_.Moved(increments, gravitation_mps2);
  return out;
}

}  // namespace dn
