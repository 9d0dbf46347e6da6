#include <dn/factors/lidar_point.h>

namespace dn {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d EndNoise(const LidarEnd& end, const Matrix3d& R_mb, const Vector3d& l_b) {
  Eigen::Matrix<double, 3, 9> J_x_increments;
  J_x_increments << -R_mb * end.partial.delta_q.toRotationMatrix() * Skew(l_b), Matrix3d::Zero(),
      R_mb;
  const auto& covariance = end.bridge ? end.bridge->covariance() : end.partial.covariance;
  return J_x_increments * covariance * J_x_increments.transpose();
}

LidarPoint::LidarPoint(const LocalFrame& frame, const Preintegrated& partial,
                       const Vector3d& p_nominal_m)
    : step_(AffineStep::Make(frame, partial.dt_s(), p_nominal_m)),
      q_C_inverse_(Exp(Vector3d(-partial.dt_s() * frame.w_ie_m()))),
      delta_q_(partial.delta_q),
      delta_v_(partial.delta_v),
      delta_p_(partial.delta_p),
      w_b_(partial.w_end_b_radps),
      w_ie_m_(frame.w_ie_m()),
      dt_s_(partial.dt_s()) {}

LidarPoint::Derivatives LidarPoint::DifferentiateAt(const Arguments& at) const {
  const Matrix3d R = at.q_mb.toRotationMatrix();
  const Vector3d u_b = at.q_boresight * at.u_b;
  const Vector3d l = at.a_b + u_b;
  const double ddt = at.ddt_s;
  const Matrix3d dR = delta_q_.toRotationMatrix();
  const Matrix3d C_inverse_R = step_.C.transpose() * R;
  const Matrix3d R_end = C_inverse_R * dR;
  const Matrix3d W = Skew(w_ie_m_);
  const Vector3d R_dp = R * delta_p_;
  const Vector3d w_x_l = w_b_.cross(l);

  Derivatives out;
  out.x = step_.p_p * at.p_mb + step_.p_v * at.v_m + step_.p_d * R_dp + step_.p_0 + R_end * l;
  out.rate = step_.v_p * at.p_mb + step_.v_v * at.v_m + step_.v_d * R_dp + C_inverse_R * delta_v_ +
             step_.v_0 + R_end * w_x_l - w_ie_m_.cross(R_end * l);

  const Matrix3d S_dp = R * Skew(delta_p_);
  const Matrix3d S_l = C_inverse_R * Skew(Vector3d(dR * l));
  const Matrix3d x_q = -step_.p_d * S_dp - S_l;
  const Matrix3d rate_q =
      -step_.v_d * S_dp - C_inverse_R * Skew(Vector3d(delta_v_ + dR * w_x_l)) + W * S_l;
  const Matrix3d l_of = R_end - ddt * (R_end * Skew(w_b_) - W * R_end);
  out.q = x_q - ddt * rate_q;
  out.p = step_.p_p - ddt * step_.v_p;
  out.v = step_.p_v - ddt * step_.v_v;
  out.theta = -l_of * Skew(u_b);
  out.a_b = l_of;
  return out;
}

Eigen::Matrix<double, 3, 9> LidarPoint::ByIncrements(const Arguments& at) const {
  const Matrix3d R = at.q_mb.toRotationMatrix();
  const Matrix3d C_inverse_R = step_.C.transpose() * R;
  const Matrix3d R_end = C_inverse_R * delta_q_.toRotationMatrix();
  const Vector3d l = at.a_b + at.q_boresight * at.u_b;
  const Matrix3d S_l = R_end * Skew(l);
  const Matrix3d rate_phi = Skew(w_ie_m_) * S_l - R_end * Skew(Vector3d(w_b_.cross(l)));
  Eigen::Matrix<double, 3, 9> J;
  J << -S_l - at.ddt_s * rate_phi, -at.ddt_s * C_inverse_R, (step_.p_d - at.ddt_s * step_.v_d) * R;
  return J;
}

Matrix3d LidarPoint::ByAttraction(double ddt_s) const {
  const Matrix3d C_inverse = step_.C.transpose(), I = Matrix3d::Identity();
  const Matrix3d position = dt_s_ * dt_s_ * (C_inverse / 3.0 + I / 6.0);
  const Matrix3d velocity = 0.5 * dt_s_ * (C_inverse + I) - Skew(w_ie_m_) * position;
  return position - ddt_s * velocity;
}

LidarPoint LidarPoint::Moved(const Eigen::Matrix<double, 9, 1>& increments,
                             const Vector3d& attraction_mps2) const {
  LidarPoint out = *this;
  out.delta_q_ = delta_q_ * Exp(Vector3d(increments.head<3>()));
  out.delta_v_ += increments.segment<3>(3);
  out.delta_p_ += increments.tail<3>();
  const Vector3d position = ByAttraction(0.0) * attraction_mps2;
  out.step_.p_0 += position;
  out.step_.v_0 += position - ByAttraction(1.0) * attraction_mps2;
  return out;
}

}  // namespace dn
