#include <dn/error.h>
#include <dn/factors/node_bridge.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <string>

namespace dn {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

IncrementConditioning::IncrementConditioning(const LocalFrame& frame, const Preintegrated& partial,
                                             const Preintegrated& whole)
    : q_C_(Exp(Vector3d(frame.w_ie_m() * whole.dt_s()))),
      delta_q_(whole.delta_q),
      J_q_effects_(whole.J_effects.topRows<3>()),
      covariance_(partial.covariance) {
  constexpr double kSameEpochS = 1e-7;
  if (std::abs(whole.t_begin_s - partial.t_begin_s) > kSameEpochS ||
      whole.J_effects.cols() != partial.J_effects.cols()) {
    throw InvalidInput("bridge: the increments from t = " + std::to_string(partial.t_begin_s) +
                       " s do not belong to those of the interval from t = " +
                       std::to_string(whole.t_begin_s) + " s");
  }
  if (partial.t_end_s > whole.t_end_s + kSameEpochS) return;
  const Matrix3d rest = (partial.delta_q.conjugate() * whole.delta_q).toRotationMatrix();
  const Matrix3d of_whole = whole.covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix<double, 9, 3> cross = partial.covariance.leftCols<3>() * rest;
  gain_ = of_whole.ldlt().solve(cross.transpose()).transpose();
  covariance_ -= gain_ * of_whole * gain_.transpose();
}

IncrementConditioning::Correction IncrementConditioning::At(
    const Quaterniond& q, const Quaterniond& q_after, const Eigen::VectorXd& d_effects) const {
  Vector3d xi = Vector3d::Zero();
  if (J_q_effects_.cols() > 0) xi = J_q_effects_ * d_effects;
  const Quaterniond turned = q.conjugate() * (q_C_ * q_after);
  const Quaterniond error = (delta_q_ * Exp(xi)).conjugate() * turned;
  const Vector3d r = Log(error);
  const Eigen::Matrix<double, 9, 3> by_turn = gain_ * RightJacobianInverse(r);
  Correction out;
  out.increments = gain_ * r;
  out.J_q = -by_turn * turned.toRotationMatrix().transpose();
  out.J_q_after = by_turn;
  out.J_whole = -by_turn * error.toRotationMatrix().transpose() * RightJacobian(xi);
  return out;
}

}  // namespace dn
