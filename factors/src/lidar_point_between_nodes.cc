#include <dn/factors/lidar_point_between_nodes.h>
#include <dn/rotation.h>

#include "vector_kind.h"

namespace dn {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Matrix3d LeftJacobian(const Vector3d& phi) { return RightJacobian(Vector3d(-phi)); }

/// Returns the change of the inertial effects since the linearisation.
VectorXd ImuChange(const LidarPointBlocks& blocks, Eigen::Index size, double const* const* x) {
  VectorXd change(size);
  Eigen::Index column = 0;
  std::size_t block = blocks.first_imu();
  for (const ImuEffectValue& one : blocks.imu) {
    const Eigen::Index values = one.value.size();
    change.segment(column, values) = Eigen::Map<const VectorXd>(x[block++], values) - one.value;
    column += values;
  }
  return change;
}

Vector3d AdditionalGravitation(const LidarPointBlocks& blocks, double const* const* x) {
  Vector3d sum = Vector3d::Zero();
  std::size_t block = blocks.first_attraction();
  for (const GravitationBasis& D : blocks.attraction) {
    sum += D * Eigen::Map<const VectorXd>(x[block++], D.cols());
  }
  return sum;
}

}  // namespace

Eigen::Index LidarPointBlocks::NumEffectValues() const {
  Eigen::Index values = TotalComponents(lidar);
  for (const ImuEffectValue& one : imu) values += one.value.size();
  for (const GravitationBasis& D : attraction) values += D.cols();
  return values;
}

void LidarPointBlocks::AppendEffectKinds(std::vector<BlockKind>* kinds) const {
  const auto add = [&](Eigen::Index size) { kinds->push_back(factors_internal::VectorKind(size)); };
  for (const auto& effect : lidar) add(effect->components());
  for (const ImuEffectValue& one : imu) add(one.value.size());
  for (const GravitationBasis& D : attraction) add(D.cols());
}

LidarPointBetweenNodes::LidarPointBetweenNodes(const LocalFrame& frame, const LidarEnd& end,
                                               const MountingBlocks& mounting, std::size_t node,
                                               std::size_t node_after)
    : point_(frame, end.partial, end.p_nominal_m),
      tag_s_(end.tag_s),
      t_end_s_(end.partial.t_end_s),
      u_s_(end.u_s),
      J_increments_(end.partial.J_effects),
      bridge_(end.bridge),
      mounting_(mounting),
      node_(node),
      node_after_(node_after),
      scanner_(end.scanner),
      beam_(end.beam) {}

LidarPointBetweenNodes::State LidarPointBetweenNodes::At(const LidarPointBlocks& blocks,
                                                         double const* const* x) const {
  State at;
  at.reading = Corrected(blocks.lidar, x + blocks.first_effect, tag_s_, u_s_, scanner_, beam_);
  double const* const* mounting = x + mounting_.first;
  at.theta = Log(Eigen::Quaterniond(mounting[0])) + at.reading.turn_b_rad;
  const VectorXd change = ImuChange(blocks, J_increments_.cols(), x);
  Eigen::Matrix<double, 9, 1> moved = Eigen::Matrix<double, 9, 1>::Zero();
  if (change.size() > 0) moved = J_increments_ * change;
  double const* const* node = x + node_;
  if (bridge_) {
    at.bridged =
        bridge_->At(Eigen::Quaterniond(node[0]), Eigen::Quaterniond(x[node_after_]), change);
    moved += at.bridged.increments;
  }
  at.turn = moved.head<3>();
  at.point = point_.Moved(moved, AdditionalGravitation(blocks, x));
  using Vec3 = Eigen::Map<const Vector3d>;
  at.arguments = {Eigen::Quaterniond(node[0]),
                  Vec3(node[1]),
                  Vec3(node[2]),
                  Exp(at.theta),
                  Vec3(mounting[1]) + at.reading.arm_b_m,
                  mounting_.R_bs_nominal * at.reading.u_s,
                  mounting[2][0] + at.reading.delay_s - (tag_s_ - t_end_s_)};
  return at;
}

Vector3d LidarPointBetweenNodes::State::Position() const {
  const LidarPoint::Arguments& a = arguments;
  return point.At<double>(a.q_mb, a.p_mb, a.v_m, a.q_boresight, a.a_b, a.u_b, a.ddt_s);
}

Eigen::Matrix<double, 3, 9> LidarPointBetweenNodes::State::IncrementJacobian() const {
  Eigen::Matrix<double, 3, 9> J = point.IncrementJacobian(arguments);
  J.leftCols<3>() = (J.leftCols<3>() * RightJacobian(turn)).eval();
  return J;
}

PointSensitivity LidarPointBetweenNodes::Sensitivity(const State& at,
                                                     const LidarPoint::Derivatives& of,
                                                     const Matrix3d& W) const {
  PointSensitivity point = ComputePointSensitivity(at.point, at.arguments, of, at.theta, W);
  point.increments = W * at.IncrementJacobian();
  if (bridge_) point.whole = point.increments * at.bridged.J_whole;
  return point;
}

void LidarPointBetweenNodes::AddEffects(const LidarPointBlocks& blocks, const State& at,
                                        const PointSensitivity& point, Matrix3Xd* sum) const {
  const Matrix3Xd* whole = bridge_ ? &bridge_->J_q_effects() : nullptr;
  AddEffectJacobians(point, {at.reading, J_increments_, whole, blocks.attraction},
                     mounting_.R_bs_nominal, *sum);
}

namespace factors_internal {

Matrix3d FromBoresightBlock(const Vector3d& theta, const double* q_boresight) {
  return LeftJacobian(theta) * LeftJacobian(Log(Eigen::Quaterniond(q_boresight))).inverse();
}

}  // namespace factors_internal

}  // namespace dn
