#include <dn/error.h>
#include <dn/factors/point_to_point_between_nodes.h>
#include <dn/rotation.h>

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr std::size_t kNodeBlocks = 3;
constexpr std::size_t kMountingBlock = 6;
constexpr std::size_t kBlocksOfMounting = 3;

std::size_t CountBridges(const PreparedPair& pair) {
  return (pair.i.bridge ? 1U : 0U) + (pair.j.bridge ? 1U : 0U);
}

/// Returns the number of blocks of nodes and scanners; the others come after them.
std::size_t CountPairBlocks(const PreparedPair& pair) {
  return kMountingBlock + (pair.R_bs_nominal_j ? 2 : 1) * kBlocksOfMounting;
}

LidarPointBlocks MakeBlocks(const PreparedPair& pair, LidarEffects lidar,
                            std::vector<GravitationBasis> attraction) {
  return {CountPairBlocks(pair) + CountBridges(pair), std::move(lidar),
          pair.i.partial.linearisation.effects, std::move(attraction)};
}

std::vector<BlockKind> Kinds(const PreparedPair& pair, const LidarPointBlocks& blocks) {
  std::vector<BlockKind> kinds{Rotation::kKind,     Vec<3>::kKind, Vec<3>::kKind,
                               Rotation::kKind,     Vec<3>::kKind, Vec<3>::kKind,
                               LeftRotation::kKind, Vec<3>::kKind, Vec<1>::kKind};
  if (pair.R_bs_nominal_j) {
    for (const BlockKind& kind : {LeftRotation::kKind, Vec<3>::kKind, Vec<1>::kKind}) {
      kinds.push_back(kind);
    }
  }
  kinds.insert(kinds.end(), CountBridges(pair), Rotation::kKind);
  blocks.AppendEffectKinds(&kinds);
  return kinds;
}

Vector3d Difference(const LidarPoint::Derivatives& i, double ddt_i,
                    const LidarPoint::Derivatives& j, double ddt_j) {
  return (i.x - ddt_i * i.rate) - (j.x - ddt_j * j.rate);
}

}  // namespace

PointToPointBetweenNodes::PointToPointBetweenNodes(const LocalFrame& frame,
                                                   const PreparedPair& pair, LidarEffects lidar,
                                                   std::vector<GravitationBasis> attraction)
    : PointToPointBetweenNodes(frame, pair,
                               MakeBlocks(pair, std::move(lidar), std::move(attraction))) {}

PointToPointBetweenNodes::PointToPointBetweenNodes(const LocalFrame& frame,
                                                   const PreparedPair& pair,
                                                   LidarPointBlocks blocks)
    : DynamicFactor(3, Kinds(pair, blocks)),
      blocks_(std::move(blocks)),
      W_(pair.noise_m.sqrt_information()) {
  factors_internal::CheckPreparedPair(pair);
  if (pair.i.partial.J_effects.cols() != pair.j.partial.J_effects.cols()) {
    throw InvalidInput(
        "point pair: the increments of its two ends have different inertial effects");
  }
  const std::size_t after = CountPairBlocks(pair);
  const MountingBlocks first{kMountingBlock, pair.R_bs_nominal};
  MountingBlocks second = first;
  if (pair.R_bs_nominal_j) second = {kMountingBlock + kBlocksOfMounting, *pair.R_bs_nominal_j};
  i_ = LidarPointBetweenNodes(frame, pair.i, first, 0, after);
  j_ = LidarPointBetweenNodes(frame, pair.j, second, kNodeBlocks, after + (pair.i.bridge ? 1 : 0));
}

void PointToPointBetweenNodes::PutMounting(const LidarPointBetweenNodes& end,
                                           const LidarPointBetweenNodes::State& at,
                                           const LidarPoint::Derivatives& of, const Matrix3d& W,
                                           double const* const* x, double** J) const {
  const auto first = static_cast<int>(end.mounting());
  Put(first, x, J,
      Matrix3d(W * of.theta * factors_internal::FromBoresightBlock(at.theta, x[end.mounting()])));
  Put(first + 1, x, J, Matrix3d(W * of.a_b));
  Put(first + 2, x, J, Vector3d(-W * of.rate));
}

bool PointToPointBetweenNodes::Evaluate(double const* const* x, double* r, double** J) const {
  using State = LidarPointBetweenNodes::State;
  const State at_i = i_.At(blocks_, x), at_j = j_.At(blocks_, x);
  const LidarPoint::Derivatives i = at_i.point.DifferentiateAt(at_i.arguments);
  const LidarPoint::Derivatives j = at_j.point.DifferentiateAt(at_j.arguments);
  Eigen::Map<Vector3d> out(r);
  out.noalias() = W_ * Difference(i, at_i.arguments.ddt_s, j, at_j.arguments.ddt_s);
  if (J == nullptr) return true;

  const auto put_bridge = [&](const LidarPointBetweenNodes& end, const State& at, const Matrix3d& W,
                              Matrix3d* J_q) {
    if (!end.has_bridge()) return;
    const Eigen::Matrix<double, 3, 9> by_increments = W * at.IncrementJacobian();
    *J_q += by_increments * at.bridged.J_q;
    Put(static_cast<int>(end.node_after()), x, J, Matrix3d(by_increments * at.bridged.J_q_after));
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
  if (i_.mounting() == j_.mounting()) {
    const auto left_jacobian = [](const Vector3d& phi) { return RightJacobian(Vector3d(-phi)); };
    const Matrix3d from_block = left_jacobian(Log(Eigen::Quaterniond(x[kMountingBlock]))).inverse();
    Put(6, x, J,
        Matrix3d(W_ * (i.theta * left_jacobian(at_i.theta) - j.theta * left_jacobian(at_j.theta)) *
                 from_block));
    Put(7, x, J, Matrix3d(W_ * (i.a_b - j.a_b)));
    Put(8, x, J, Vector3d(-W_ * (i.rate - j.rate)));
  } else {
    PutMounting(i_, at_i, i, W_, x, J);
    PutMounting(j_, at_j, j, -W_, x, J);
  }
  if (blocks_.num_effects() == 0) return true;

  Matrix3Xd J_r_c = Matrix3Xd::Zero(3, blocks_.NumEffectValues());
  i_.AddEffects(blocks_, at_i, i_.Sensitivity(at_i, i, W_), &J_r_c);
  j_.AddEffects(blocks_, at_j, j_.Sensitivity(at_j, j, -W_), &J_r_c);
  Eigen::Index column = 0;
  for (std::size_t block = blocks_.first_effect; block < block_kinds().size(); ++block) {
    const int size = block_kinds()[block].stored_size;
    Put(static_cast<int>(block), x, J, Matrix3Xd(J_r_c.middleCols(column, size)));
    column += size;
  }
  return true;
}

std::optional<PointSensitivity> PointToPointBetweenNodes::SensitivityAt(
    PointPairFactor::End of, double const* const* x) const {
  const LidarPointBetweenNodes& end = Point(of);
  const LidarPointBetweenNodes::State at = end.At(blocks_, x);
  return end.Sensitivity(at, at.point.DifferentiateAt(at.arguments),
                         of == PointPairFactor::End::kI ? W_ : Matrix3d(-W_));
}

std::pair<Vector3d, Vector3d> PointToPointBetweenNodes::Points(double const* const* x) const {
  return {i_.At(blocks_, x).Position(), j_.At(blocks_, x).Position()};
}

}  // namespace dn
