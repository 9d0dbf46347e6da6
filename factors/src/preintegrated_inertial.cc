#include <dn/error.h>
#include <dn/factors/preintegrated_inertial.h>

#include <algorithm>
#include <string>
#include <vector>

#include "vector_kind.h"

namespace dn {
namespace {

std::vector<BlockKind> Kinds(int num_gyro_biases, int num_accel_biases,
                             const ImuEffectValues& effects,
                             const std::vector<GravitationBasis>& attraction) {
  if (num_gyro_biases < 0 || num_accel_biases < 0) {
    throw InvalidInput("inertial edge: the numbers of bias blocks are " +
                       std::to_string(num_gyro_biases) + " and " +
                       std::to_string(num_accel_biases) + ", must not be negative");
  }
  std::vector<BlockKind> kinds{Rotation::kKind, Vec<3>::kKind, Vec<3>::kKind,
                               Rotation::kKind, Vec<3>::kKind, Vec<3>::kKind};
  kinds.insert(kinds.end(), static_cast<std::size_t>(num_gyro_biases), Vec<3>::kKind);
  kinds.insert(kinds.end(), static_cast<std::size_t>(num_accel_biases), Vec<3>::kKind);
  for (const ImuEffectValue& one : effects)
    kinds.push_back(factors_internal::VectorKind(one.value.size()));
  for (const GravitationBasis& one : attraction)
    kinds.push_back(factors_internal::VectorKind(one.cols()));
  return kinds;
}

Eigen::Matrix<double, 9, 9> SqrtInformation(const Preintegrated& increments) {
  try {
    return Noise<9>::Covariance(increments.covariance).sqrt_information();
  } catch (const InvalidInput&) {
    throw InvalidInput("inertial edge from t = " + std::to_string(increments.t_begin_s) + " to " +
                       std::to_string(increments.t_end_s) +
                       " s: the covariance of its increments is not finite or not positive "
                       "definite; check the white noise of gyros and accelerometers, and the "
                       "inertial data there");
  }
}

}  // namespace

PreintegratedInertial::PreintegratedInertial(const Preintegrated& increments,
                                             const LocalFrame& frame,
                                             const Eigen::Vector3d& p_i_nominal_m,
                                             const Eigen::Vector3d& p_j_nominal_m,
                                             int num_gyro_biases, int num_accel_biases,
                                             const std::vector<GravitationBasis>& attraction)
    : DynamicFactor(9, Kinds(num_gyro_biases, num_accel_biases, increments.linearisation.effects,
                             attraction)),
      increments_(increments),
      num_gyro_biases_(num_gyro_biases),
      num_accel_biases_(num_accel_biases),
      W_(SqrtInformation(increments)) {
  const double dt = increments.dt_s();
  if (!(dt > 0.0)) {
    throw InvalidInput(
        "inertial edge: the increments from t = " + std::to_string(increments.t_begin_s) +
        " s cover " + std::to_string(dt) + " s, must be positive");
  }
  if (!p_i_nominal_m.allFinite() || !p_j_nominal_m.allFinite()) {
    throw InvalidInput("inertial edge: the nominal position at t = " +
                       std::to_string(increments.t_begin_s) + " s is not finite");
  }
  const EarthStep earth = EarthStep::Make(frame, dt);
  const Eigen::Matrix3d W = Skew(frame.w_ie_m());
  // One gradient is used for both ends: its relative change between them is 3e-7 per metre.
  const Eigen::Matrix3d Gamma = GravitationGradient(frame, 0.5 * (p_i_nominal_m + p_j_nominal_m));
  const Eigen::Vector3d G_i = frame.Gravitation(p_i_nominal_m) - Gamma * p_i_nominal_m;
  const Eigen::Vector3d G_j = frame.Gravitation(p_j_nominal_m) - Gamma * p_j_nominal_m;
  C_ = earth.C;
  q_C_ = Exp(Eigen::Vector3d(frame.w_ie_m() * dt));
  v_p_i_ = -W - 0.5 * dt * Gamma;
  v_p_j_ = C_ * (W - 0.5 * dt * Gamma);
  v_0_ = earth.origin_velocity_mps - 0.5 * dt * (G_i + C_ * G_j);
  p_p_i_ = -Eigen::Matrix3d::Identity() - dt * W - dt * dt / 3.0 * Gamma;
  p_p_j_ = C_ * (Eigen::Matrix3d::Identity() - dt * dt / 6.0 * Gamma);
  p_0_ = earth.origin_position_m - dt * dt * (G_i / 3.0 + C_ * G_j / 6.0);
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  for (const GravitationBasis& D : attraction) {
    attraction_.push_back({-0.5 * dt * (I + C_) * D, -dt * dt * (I / 3.0 + C_ / 6.0) * D});
  }
}

bool PreintegratedInertial::Evaluate(double const* const* x, double* r, double** J) const {
  Residual(x, r);
  if (J != nullptr) EvaluateJacobians(x, J);
  return true;
}

void PreintegratedInertial::EvaluateJacobians(double const* const* x, double** J) const {
  using Vec3 = Eigen::Vector3d;
  using Mat3 = Eigen::Matrix3d;
  using Block = Eigen::Matrix<double, 9, 3>;
  const Eigen::Quaterniond q_i(x[0]), q_j(x[3]);
  const Eigen::Map<const Vec3> p_i(x[1]), v_i(x[2]), p_j(x[4]), v_j(x[5]);
  const Mat3 R_i_inverse = q_i.toRotationMatrix().transpose();
  const Mat3 R_ij = R_i_inverse * C_ * q_j.toRotationMatrix();
  const Mat3 R_C = R_i_inverse * C_;

  const Vec3 d_bg = SumBlocks(x + 6, num_gyro_biases_) - increments_.linearisation.gyro_bias_radps;
  Vec3 xi = increments_.J_q_bg * d_bg;
  xi += EffectIncrements(x).head<3>();
  const Eigen::Quaterniond dq = increments_.delta_q * Exp(xi);
  const Eigen::Quaterniond error = dq.conjugate() * Eigen::Quaterniond(R_ij);
  const Mat3 J_R = RightJacobianInverse(Log(error));
  Vec3 v_attraction = Vec3::Zero(), p_attraction = Vec3::Zero();
  AddGravitation(x, &v_attraction, &p_attraction);
  const Vec3 y_v =
      R_i_inverse * (C_ * v_j - v_i + v_p_i_ * p_i + v_p_j_ * p_j + v_0_ + v_attraction);
  const Vec3 y_p =
      R_i_inverse * (p_p_i_ * p_i + p_p_j_ * p_j + p_0_ + p_attraction - increments_.dt_s() * v_i);

  // Uses that W is lower triangular.
  const auto whiten = [&](const Mat3& J_R_x, const Mat3& J_v_x, const Mat3& J_p_x) {
    Block whitened;
    whitened.topRows<3>().noalias() = W_.block<3, 3>(0, 0) * J_R_x;
    whitened.middleRows<3>(3).noalias() =
        W_.block<3, 3>(3, 0) * J_R_x + W_.block<3, 3>(3, 3) * J_v_x;
    whitened.bottomRows<3>().noalias() =
        W_.block<3, 3>(6, 0) * J_R_x + W_.block<3, 3>(6, 3) * J_v_x + W_.block<3, 3>(6, 6) * J_p_x;
    return whitened;
  };
  const auto put = [&](int block, const Mat3& J_R_x, const Mat3& J_v_x, const Mat3& J_p_x) {
    if (J[block] != nullptr) Put(block, x, J, whiten(J_R_x, J_v_x, J_p_x));
  };
  const auto put_all = [&](int first, int count, const Block& whitened) {
    for (int block = first; block < first + count; ++block) {
      if (J[block] != nullptr) Put(block, x, J, whitened);
    }
  };
  const Mat3 zero = Mat3::Zero();
  put(0, -J_R * R_ij.transpose(), Skew(y_v), Skew(y_p));
  put(1, zero, R_i_inverse * v_p_i_, R_i_inverse * p_p_i_);
  put(2, zero, -R_i_inverse, -increments_.dt_s() * R_i_inverse);
  put(3, J_R, zero, zero);
  put(4, zero, R_i_inverse * v_p_j_, R_i_inverse * p_p_j_);
  put(5, zero, R_C, zero);
  const Mat3 J_R_xi = -J_R * error.toRotationMatrix().transpose() * RightJacobian(xi);
  put_all(6, num_gyro_biases_,
          whiten(J_R_xi * increments_.J_q_bg, -increments_.J_v_bg, -increments_.J_p_bg));
  put_all(6 + num_gyro_biases_, num_accel_biases_,
          whiten(zero, -increments_.J_v_ba, -increments_.J_p_ba));
  EvaluateEffectJacobians(x, J_R_xi, R_i_inverse, J);
}

void PreintegratedInertial::EvaluateEffectJacobians(double const* const* x,
                                                    const Eigen::Matrix3d& J_R_xi,
                                                    const Eigen::Matrix3d& R_i_inverse,
                                                    double** J) const {
  const auto put = [&](int block, const Eigen::Matrix<double, 9, Eigen::Dynamic>& unwhitened) {
    if (J[block] == nullptr) return;
    Put(block, x, J, (W_.triangularView<Eigen::Lower>() * unwhitened).eval());
  };
  Eigen::Index column = 0;
  int block = first_effect();
  for (const ImuEffectValue& one : increments_.linearisation.effects) {
    Eigen::Matrix<double, 9, Eigen::Dynamic> J_r_e =
        -increments_.J_effects.middleCols(column, one.value.size());
    J_r_e.topRows<3>() = -J_R_xi * J_r_e.topRows<3>();
    put(block++, J_r_e);
    column += one.value.size();
  }
  for (const GravitationBracket& one : attraction_) {
    Eigen::Matrix<double, 9, Eigen::Dynamic> J_r_g(9, one.v.cols());
    J_r_g << Eigen::Matrix3Xd::Zero(3, one.v.cols()), R_i_inverse * one.v, R_i_inverse * one.p;
    put(block++, J_r_g);
  }
}

}  // namespace dn
