#include <dn/error.h>
#include <dn/factors/point_to_point_between_nodes.h>

#include "vector_kind.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kPairBlocks = 9;
constexpr std::size_t kNodeBlocks = 3;

std::size_t CountBridges(const PreparedPair& pair) {
  return (pair.i.bridge ? 1U : 0U) + (pair.j.bridge ? 1U : 0U);
}

std::vector<BlockKind> Kinds(std::size_t bridges, const LidarEffects& lidar,
                             const ImuEffectValues& imu,
                             const std::vector<GravitationBasis>& attraction) {
  std::vector<BlockKind> kinds{Rotation::kKind,     Vec<3>::kKind, Vec<3>::kKind,
                               Rotation::kKind,     Vec<3>::kKind, Vec<3>::kKind,
                               LeftRotation::kKind, Vec<3>::kKind, Vec<1>::kKind};
  kinds.insert(kinds.end(), bridges, Rotation::kKind);
  const auto add = [&](Eigen::Index size) { kinds.push_back(factors_internal::VectorKind(size)); };
  for (const auto& effect : lidar) add(effect->components());
  for (const ImuEffectValue& one : imu) add(one.value.size());
  for (const GravitationBasis& D : attraction) add(D.cols());
  return kinds;
}

Matrix3d LeftJacobian(const Vector3d& phi) { return RightJacobian(Vector3d(-phi)); }

Vector3d Difference(const LidarPoint::Derivatives& i, double ddt_i,
                    const LidarPoint::Derivatives& j, double ddt_j) {
  return (i.x - ddt_i * i.rate) - (j.x - ddt_j * j.rate);
}

}  // namespace

PointToPointBetweenNodes::PointToPointBetweenNodes(const LocalFrame& frame,
                                                   const PreparedPair& pair, LidarEffects lidar,
                                                   std::vector<GravitationBasis> attraction)
    : DynamicFactor(
          3, Kinds(CountBridges(pair), lidar, pair.i.partial.linearisation.effects, attraction)),
      first_lidar_block_(kPairBlocks + CountBridges(pair)),
      lidar_(std::move(lidar)),
      imu_(pair.i.partial.linearisation.effects),
      attraction_(std::move(attraction)),
      R_bs_nominal_(pair.R_bs_nominal),
      W_(pair.noise_m.sqrt_information()) {
  factors_internal::CheckPreparedPair(pair);
  if (pair.i.partial.J_effects.cols() != pair.j.partial.J_effects.cols()) {
    throw InvalidInput(
        "point pair: the increments of its two ends have different inertial effects");
  }
  i_ = MakeEnd(frame, pair.i, 0, kPairBlocks);
  j_ = MakeEnd(frame, pair.j, kNodeBlocks, kPairBlocks + (pair.i.bridge ? 1 : 0));
}

PointToPointBetweenNodes::End PointToPointBetweenNodes::MakeEnd(const LocalFrame& frame,
                                                                const LidarEnd& end,
                                                                std::size_t node,
                                                                std::size_t node_after) {
  return {LidarPoint(frame, end.partial, end.p_nominal_m),
          end.tag_s,
          end.partial.t_end_s,
          end.u_s,
          end.partial.J_effects,
          end.bridge,
          node,
          node_after};
}

VectorXd PointToPointBetweenNodes::ImuChange(double const* const* x) const {
  VectorXd change(i_.J_increments.cols());
  Eigen::Index column = 0;
  std::size_t block = first_imu_block();
  for (const ImuEffectValue& one : imu_) {
    const Eigen::Index size = one.value.size();
    change.segment(column, size) = Eigen::Map<const VectorXd>(x[block++], size) - one.value;
    column += size;
  }
  return change;
}

Eigen::Index PointToPointBetweenNodes::NumEffectValues() const {
  Eigen::Index values = 0;
  for (std::size_t block = first_lidar_block_; block < block_kinds().size(); ++block) {
    values += block_kinds()[block].stored_size;
  }
  return values;
}

Vector3d PointToPointBetweenNodes::AdditionalGravitation(double const* const* x) const {
  Vector3d sum = Vector3d::Zero();
  std::size_t block = first_attraction_block();
  for (const GravitationBasis& D : attraction_) {
    sum += D * Eigen::Map<const VectorXd>(x[block++], D.cols());
  }
  return sum;
}

PointToPointBetweenNodes::EndAt PointToPointBetweenNodes::At(const End& end,
                                                             double const* const* x) const {
  EndAt at;
  at.reading = Corrected(lidar_, x + first_lidar_block_, end.tag_s, end.u_s);
  at.theta = Log(Eigen::Quaterniond(x[6])) + at.reading.turn_b_rad;
  const VectorXd change = ImuChange(x);
  Eigen::Matrix<double, 9, 1> moved = Eigen::Matrix<double, 9, 1>::Zero();
  if (change.size() > 0) moved = end.J_increments * change;
  double const* const* node = x + end.node;
  if (end.bridge) {
    at.bridged =
        end.bridge->At(Eigen::Quaterniond(node[0]), Eigen::Quaterniond(x[end.node_after]), change);
    moved += at.bridged.increments;
  }
  at.turn = moved.head<3>();
  at.point = end.point.Moved(moved, AdditionalGravitation(x));
  using Vec3 = Eigen::Map<const Vector3d>;
  at.arguments = {Eigen::Quaterniond(node[0]),
                  Vec3(node[1]),
                  Vec3(node[2]),
                  Exp(at.theta),
                  Vec3(x[7]) + at.reading.arm_b_m,
                  R_bs_nominal_ * at.reading.u_s,
                  x[8][0] + at.reading.delay_s - (end.tag_s - end.t_end_s)};
  return at;
}

Eigen::Matrix<double, 3, 9> PointToPointBetweenNodes::IncrementJacobian(const EndAt& at) {
  Eigen::Matrix<double, 3, 9> J = at.point.IncrementJacobian(at.arguments);
  J.leftCols<3>() = (J.leftCols<3>() * RightJacobian(at.turn)).eval();
  return J;
}

PointSensitivity PointToPointBetweenNodes::EndSensitivity(const End& end, const EndAt& at,
                                                          const LidarPoint::Derivatives& of,
                                                          const Matrix3d& W) {
  PointSensitivity point = ComputePointSensitivity(at.point, at.arguments, of, at.theta, W);
  point.increments = W * IncrementJacobian(at);
  if (end.bridge) point.whole = point.increments * at.bridged.J_whole;
  return point;
}

void PointToPointBetweenNodes::AddEndEffectJacobians(const End& end, const EndAt& at,
                                                     const PointSensitivity& point,
                                                     Matrix3Xd* sum) const {
  const Matrix3Xd* whole = end.bridge ? &end.bridge->J_q_effects() : nullptr;
  AddEffectJacobians(point, {at.reading, end.J_increments, whole, attraction_}, R_bs_nominal_,
                     *sum);
}

bool PointToPointBetweenNodes::Evaluate(double const* const* x, double* r, double** J) const {
  const EndAt at_i = At(i_, x), at_j = At(j_, x);
  LidarPoint::Derivatives i = at_i.point.DifferentiateAt(at_i.arguments);
  LidarPoint::Derivatives j = at_j.point.DifferentiateAt(at_j.arguments);
  Eigen::Map<Vector3d> out(r);
  out.noalias() = W_ * Difference(i, at_i.arguments.ddt_s, j, at_j.arguments.ddt_s);
  if (J == nullptr) return true;

  const auto put_bridge = [&](const End& end, const EndAt& at, const Matrix3d& W, Matrix3d* J_q) {
    if (!end.bridge) return;
    const Eigen::Matrix<double, 3, 9> by_increments = W * IncrementJacobian(at);
    *J_q += by_increments * at.bridged.J_q;
    Put(static_cast<int>(end.node_after), x, J, Matrix3d(by_increments * at.bridged.J_q_after));
  };
  Matrix3d J_q_i = W_ * i.q, J_q_j = -W_ * j.q;
  put_bridge(i_, at_i, W_, &J_q_i);
  put_bridge(j_, at_j, -W_, &J_q_j);
  Put(0, x, J, J_q_i);
  Put(1, x, J, Matrix3d(W_ * i.p));
  Put(2, x, J, Matrix3d(W_ * i.v));
  Put(3, x, J, J_q_j);
  Put(4, x, J, Matrix3d(-W_ * j.p));
  Put(5, x, J, Matrix3d(-W_ * j.v));
  const Matrix3d from_block = LeftJacobian(Log(Eigen::Quaterniond(x[6]))).inverse();
  Put(6, x, J,
      Matrix3d(W_ * (i.theta * LeftJacobian(at_i.theta) - j.theta * LeftJacobian(at_j.theta)) *
               from_block));
  Put(7, x, J, Matrix3d(W_ * (i.a_b - j.a_b)));
  Put(8, x, J, Vector3d(-W_ * (i.rate - j.rate)));
  if (first_lidar_block_ == block_kinds().size()) return true;

  Matrix3Xd J_r_c = Matrix3Xd::Zero(3, NumEffectValues());
  AddEndEffectJacobians(i_, at_i, EndSensitivity(i_, at_i, i, W_), &J_r_c);
  AddEndEffectJacobians(j_, at_j, EndSensitivity(j_, at_j, j, -W_), &J_r_c);
  Eigen::Index column = 0;
  for (std::size_t block = first_lidar_block_; block < block_kinds().size(); ++block) {
    const int size = block_kinds()[block].stored_size;
    Put(static_cast<int>(block), x, J, Matrix3Xd(J_r_c.middleCols(column, size)));
    column += size;
  }
  return true;
}

std::optional<PointSensitivity> PointToPointBetweenNodes::SensitivityAt(
    PointPairFactor::End of, double const* const* x) const {
  const bool first = of == PointPairFactor::End::kI;
  const End& end = first ? i_ : j_;
  const EndAt at = At(end, x);
  return EndSensitivity(end, at, at.point.DifferentiateAt(at.arguments),
                        first ? W_ : Matrix3d(-W_));
}

std::pair<Vector3d, Vector3d> PointToPointBetweenNodes::Points(double const* const* x) const {
  const auto point = [&](const EndAt& at) {
    const LidarPoint::Arguments& a = at.arguments;
    return at.point.At<double>(a.q_mb, a.p_mb, a.v_m, a.q_boresight, a.a_b, a.u_b, a.ddt_s);
  };
  return {point(At(i_, x)), point(At(j_, x))};
}

}  // namespace dn
