#include <dn/error.h>
#include <dn/factors/point_to_point.h>

#include <cmath>
#include <string>

namespace dn {
namespace {

void CheckEnd(const LidarEnd& end) {
  if (!end.u_s.allFinite() || !(end.u_s.norm() > 0.0)) {
    throw InvalidInput("point pair: the laser vector at t = " +
                       std::to_string(end.partial.t_end_s) + " s is zero or not finite");
  }
  if (!end.p_nominal_m.allFinite()) {
    throw InvalidInput("point pair: the nominal position at t = " +
                       std::to_string(end.partial.t_begin_s) + " s is not finite");
  }
}

void CheckMounting(const Eigen::Matrix3d& T_bs) {
  constexpr double kTolerance = 1e-6;  // a matrix written with seven digits
  const double defect = (T_bs * T_bs.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(defect < kTolerance) || T_bs.determinant() < 0.0) {
    throw InvalidInput(
        "point pair: the mounting matrix is no rotation (T T^T differs from the identity by " +
        std::to_string(defect) + ", determinant " + std::to_string(T_bs.determinant()) + ")");
  }
}

}  // namespace

Eigen::Matrix3d EndNoise(const LidarEnd& end, const Eigen::Matrix3d& R_mb,
                         const Eigen::Vector3d& l_b) {
  Eigen::Matrix<double, 3, 9> J_x_increments;
  J_x_increments << -R_mb * end.partial.delta_q.toRotationMatrix() * Skew(l_b),
      Eigen::Matrix3d::Zero(), R_mb;
  return J_x_increments * end.partial.covariance * J_x_increments.transpose();
}

struct PointToPoint::EndJacobians {
  Eigen::Vector3d x, rate;              // the point at the epoch, and its velocity, map
  Eigen::Matrix3d q, p, v, theta, a_b;  // of the point moved by -ddt rate
};

PointToPoint::PointToPoint(const LocalFrame& frame, const LidarEnd& i, const LidarEnd& j,
                           const Eigen::Matrix3d& T_bs_nominal, double dt_nominal_s,
                           const Noise<3>& noise_m)
    : w_ie_m_(frame.w_ie_m()), dt_nominal_s_(dt_nominal_s), W_(noise_m.sqrt_information()) {
  if (!std::isfinite(dt_nominal_s)) {
    throw InvalidInput("point pair: the nominal time offset is not finite");
  }
  CheckMounting(T_bs_nominal);
  CheckEnd(i);
  CheckEnd(j);
  i_ = MakeEnd(frame, i, T_bs_nominal);
  j_ = MakeEnd(frame, j, T_bs_nominal);
}

PointToPoint::End PointToPoint::MakeEnd(const LocalFrame& frame, const LidarEnd& end,
                                        const Eigen::Matrix3d& T_bs) {
  const double dt = end.partial.dt_s();
  return {AffineStep::Make(frame, dt, end.p_nominal_m),
          Exp(Eigen::Vector3d(-dt * frame.w_ie_m())),
          end.partial.delta_q,
          end.partial.delta_v,
          end.partial.delta_p,
          end.partial.w_end_b_radps,
          T_bs * end.u_s};
}

PointToPoint::EndJacobians PointToPoint::JacobiansOf(const End& end, double const* const* node,
                                                     double const* const* x) const {
  using Vec3 = Eigen::Vector3d;
  using Mat3 = Eigen::Matrix3d;
  const AffineStep& step = end.step;
  const Mat3 R = Eigen::Quaterniond(node[0]).toRotationMatrix();
  const Eigen::Map<const Vec3> p(node[1]), v(node[2]);
  const Vec3 u_b = Eigen::Quaterniond(x[6]) * end.u_b;
  const Vec3 l = Eigen::Map<const Vec3>(x[7]) + u_b;
  const double ddt = x[8][0] - dt_nominal_s_;
  const Mat3 dR = end.delta_q.toRotationMatrix();
  const Mat3 C_inverse_R = step.C.transpose() * R;
  const Mat3 R_end = C_inverse_R * dR;
  const Mat3 W = Skew(w_ie_m_);
  const Vec3 R_dp = R * end.delta_p;
  const Vec3 w_x_l = end.w_b.cross(l);

  EndJacobians out;
  out.x = step.p_p * p + step.p_v * v + step.p_d * R_dp + step.p_0 + R_end * l;
  out.rate = step.v_p * p + step.v_v * v + step.v_d * R_dp + C_inverse_R * end.delta_v + step.v_0 +
             R_end * w_x_l - w_ie_m_.cross(R_end * l);

  const Mat3 S_dp = R * Skew(end.delta_p);
  const Mat3 S_l = C_inverse_R * Skew(Vec3(dR * l));
  const Mat3 x_q = -step.p_d * S_dp - S_l;
  const Mat3 rate_q =
      -step.v_d * S_dp - C_inverse_R * Skew(Vec3(end.delta_v + dR * w_x_l)) + W * S_l;
  const Mat3 l_of = R_end - ddt * (R_end * Skew(end.w_b) - W * R_end);
  out.q = x_q - ddt * rate_q;
  out.p = step.p_p - ddt * step.v_p;
  out.v = step.p_v - ddt * step.v_v;
  out.theta = -l_of * Skew(u_b);
  out.a_b = l_of;
  return out;
}

bool PointToPoint::Evaluate(double const* const* x, double* r, double** J) const {
  const EndJacobians i = JacobiansOf(i_, x, x);
  const EndJacobians j = JacobiansOf(j_, x + 3, x);
  const double ddt = x[8][0] - dt_nominal_s_;
  const Eigen::Vector3d difference = (i.x - j.x) - ddt * (i.rate - j.rate);
  Eigen::Map<Eigen::Vector3d> out(r);
  out.noalias() = W_ * difference;

  Put<0>(x, J, Eigen::Matrix3d(W_ * i.q));
  Put<1>(x, J, Eigen::Matrix3d(W_ * i.p));
  Put<2>(x, J, Eigen::Matrix3d(W_ * i.v));
  Put<3>(x, J, Eigen::Matrix3d(-W_ * j.q));
  Put<4>(x, J, Eigen::Matrix3d(-W_ * j.p));
  Put<5>(x, J, Eigen::Matrix3d(-W_ * j.v));
  Put<6>(x, J, Eigen::Matrix3d(W_ * (i.theta - j.theta)));
  Put<7>(x, J, Eigen::Matrix3d(W_ * (i.a_b - j.a_b)));
  Put<8>(x, J, Eigen::Vector3d(-W_ * (i.rate - j.rate)));
  return true;
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> PointToPoint::Points(double const* const* x) const {
  const Eigen::Quaterniond q_boresight(x[6]);
  const Eigen::Vector3d a_b = Eigen::Map<const Eigen::Vector3d>(x[7]);
  const double ddt = x[8][0] - dt_nominal_s_;
  return {Point<double>(i_, x[0], x[1], x[2], q_boresight, a_b, ddt),
          Point<double>(j_, x[3], x[4], x[5], q_boresight, a_b, ddt)};
}

std::pair<PointToPoint::EndDerivatives, PointToPoint::EndDerivatives>
PointToPoint::DerivativesOfEnds(double const* const* x) const {
  const Eigen::Quaterniond q_boresight(x[6]);
  const EndJacobians i = JacobiansOf(i_, x, x);
  const EndJacobians j = JacobiansOf(j_, x + 3, x);
  return {{W_ * i.a_b, -W_ * i.rate, q_boresight * i_.u_b},
          {-W_ * j.a_b, W_ * j.rate, q_boresight * j_.u_b}};
}

}  // namespace dn
