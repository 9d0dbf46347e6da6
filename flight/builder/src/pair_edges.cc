#include <dn/builder/node_grid.h>
#include <dn/builder/pair_edges.h>
#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/parallel.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "append.h"
#include "factor_groups.h"

namespace dn {
namespace {

using End = PointPairFactor::End;

// Limit for counting white noise twice. Below this fraction of the variance of a pair, the white
// noise of the increments to its epochs is also counted in the inertial edges. The sum of squares
// is then too small by at most this fraction.
constexpr double kNoiseCountedTwice = 1e-4;
// Pairs per batch; the increments of one batch need little memory compared with the network.
constexpr std::size_t kPairsAtOnce = 1 << 15;

/// A pair end with the node to which it is attached.
struct AttachedEnd {
  PairEndIndex end;
  std::size_t node;
  double epoch_s;
};

/// Returns the pair ends sorted by node, then by time.
std::vector<AttachedEnd> EndsInOrder(std::span<const PairEdge> edges,
                                     const PairCalibration& calibration) {
  std::vector<AttachedEnd> ends;
  ends.reserve(2 * edges.size());
  const auto epoch = [&](const LaserShot& shot) {
    return calibration.EmissionTime(calibration.Read(shot));
  };
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const LidarPair& pair = edges[k].pair;
    ends.push_back({{k, End::kI}, edges[k].node_i, epoch(ShotI(pair))});
    ends.push_back({{k, End::kJ}, edges[k].node_j, epoch(ShotJ(pair))});
  }
  std::sort(ends.begin(), ends.end(), [](const AttachedEnd& a, const AttachedEnd& b) {
    return std::tie(a.node, a.epoch_s) < std::tie(b.node, b.epoch_s);
  });
  return ends;
}

/// Calls use(end, increments) for all ends; ends of different nodes are processed in parallel.
/// from_node(node) returns the EndIncrements of a node.
template <class FromNode, class Use>
void ForAttachedEnds(const std::vector<AttachedEnd>& ends, int threads, const FromNode& from_node,
                     const Use& use) {
  std::vector<std::size_t> firsts;  // index of the first end of each node
  for (std::size_t k = 0; k < ends.size(); ++k) {
    if (k == 0 || ends[k].node != ends[k - 1].node) firsts.push_back(k);
  }
  firsts.push_back(ends.size());
  ParallelFor(static_cast<int>(firsts.size()) - 1, threads, [&](int n) {
    const std::size_t first = firsts[static_cast<std::size_t>(n)];
    EndIncrements increments = from_node(ends[first].node);
    for (std::size_t k = first; k < firsts[static_cast<std::size_t>(n) + 1]; ++k) {
      use(ends[k].end, increments.To(ends[k].epoch_s));
    }
  });
}

}  // namespace

void PairEdges::SetModel(PairModel model) {
  const std::vector<std::size_t> effects = PairEffectIndices(context_.calibration.State());
  if (!effects.empty()) {
    throw InvalidInput("pair model: factors of a pair model cannot estimate '" +
                       context_.calibration.effects()[effects.front()].name +
                       "'; remove it from `estimate`");
  }
  if (NumScanners(context_.flight.config) > 1) {
    throw InvalidInput("pair model: a flight with several scanners has the factors of the library");
  }
  model_ = std::move(model);
}

void PairEdges::Add(const std::vector<LidarPair>& pairs) {
  const double margin_s = context_.calibration.MovesLidarEpochs() ? kLidarTimeMarginS : -1e-7;
  const CalibrationState calibration = context_.calibration.State();
  const std::vector<BlockId> effects =
      context_.calibration.EffectIds(PairEffectIndices(calibration));
  std::vector<PairEdge> edges;
  for (const LidarPair& pair : pairs) {
    if (std::optional<PairEdge> edge = Attach(pair, margin_s)) edges.push_back(std::move(*edge));
  }
  ForFactors(edges, calibration, [&](PairEdge& edge, const auto& make) {
    std::vector<BlockId> blocks = Blocks(edge);
    builder_internal::Append(effects, &blocks);
    edge.id = context_.factors.Add(make(), blocks, builder_internal::PairGroup(), edge.pair.t_i_s);
    edges_.push_back(std::move(edge));
  });
}

std::optional<PairEdge> PairEdges::Attach(const LidarPair& pair, double margin_s) {
  const std::vector<double>& node_t_s = context_.trajectory.node_times();
  const ImuData& imu = *context_.flight.imu;
  PairEdge edge{pair, NodeBefore(node_t_s, pair.t_i_s - margin_s),
                NodeBefore(node_t_s, pair.t_j_s - margin_s)};
  if (edge.node_i == edge.node_j) {
    ++within_one_node_;
    return std::nullopt;
  }
  if (HasGap(imu, node_t_s[edge.node_i], pair.t_i_s) ||
      HasGap(imu, node_t_s[edge.node_j], pair.t_j_s)) {
    ++in_imu_gaps_;
    return std::nullopt;
  }
  if (!model_) Bridge(&edge);
  return edge;
}

// The noise of an end must not be conditioned on the attitude of the node of the other end. Pairs
// whose ends follow neighbouring nodes therefore have no bridge.
void PairEdges::Bridge(PairEdge* edge) const {
  const auto [first, second] = std::minmax(edge->node_i, edge->node_j);
  if (second - first < 2) return;
  const double sigma_m = PairSigma(context_.flight.config, edge->pair);
  const double variance_m2 =
      edge->pair.covariance_m2 ? edge->pair.covariance_m2->trace() / 3.0 : sigma_m * sigma_m;
  const auto find_bridge = [&](std::size_t node, double range_m) -> std::optional<std::size_t> {
    const std::optional<std::size_t> k = inertial_.FindEdge(node);
    if (!k) return std::nullopt;
    const double turn_rad2 =
        inertial_.FactorInUse(inertial_.edges()[*k])->increments().covariance(0, 0);
    const double added_m2 = turn_rad2 * range_m * range_m;
    return added_m2 <= kNoiseCountedTwice * variance_m2 ? std::nullopt : k;
  };
  edge->bridge_i = find_bridge(edge->node_i, edge->pair.u_i_s.norm());
  edge->bridge_j = find_bridge(edge->node_j, edge->pair.u_j_s.norm());
}

std::vector<BlockId> PairEdges::Blocks(const PairEdge& edge) const {
  const TrajectoryGraph& trajectory = context_.trajectory;
  std::vector<BlockId> blocks = trajectory.NodeIds(edge.node_i);
  builder_internal::Append(trajectory.NodeIds(edge.node_j), &blocks);
  const auto append_mounting = [&](int scanner) {
    const ScannerBlocks& own = context_.calibration.scanners()[static_cast<std::size_t>(scanner)];
    builder_internal::Append({own.boresight.id, own.lever_arm.id, own.time_offset.id}, &blocks);
  };
  append_mounting(edge.pair.scanner_i);
  if (edge.pair.scanner_j != edge.pair.scanner_i) append_mounting(edge.pair.scanner_j);
  if (edge.bridge_i) blocks.push_back(trajectory.nodes()[edge.node_i + 1].q_mb.id);
  if (edge.bridge_j) blocks.push_back(trajectory.nodes()[edge.node_j + 1].q_mb.id);
  if (model_) builder_internal::Append(model_->blocks, &blocks);
  return blocks;
}

std::vector<PairEdges::PartialIncrements> PairEdges::Integrate(
    std::span<const PairEdge> edges, const PairCalibration& calibration) const {
  std::vector<PartialIncrements> increments(edges.size());
  const auto from_node = [&](std::size_t node) {
    const double node_t_s = context_.trajectory.node_times()[node];
    return EndIncrements(*context_.flight.imu, calibration.state(), context_.noise, node_t_s,
                         context_.trajectory.BiasesAt(node_t_s));
  };
  ForAttachedEnds(EndsInOrder(edges, calibration), context_.threads, from_node,
                  [&](const PairEndIndex& end, Preintegrated partial) {
                    increments[end.k][end.end == End::kI ? 0 : 1] = std::move(partial);
                  });
  return increments;
}

void PairEdges::ForEnds(const CalibrationState& calibration, const ImuData& imu, int threads,
                        const UseEnd& use) const {
  const PreintegrationNoise none;
  const auto from_node = [&](std::size_t node) {
    const double node_t_s = context_.trajectory.node_times()[node];
    return EndIncrements(imu, calibration, none, node_t_s, context_.trajectory.BiasesAt(node_t_s));
  };
  ForAttachedEnds(EndsInOrder(edges_, PairCalibration(calibration)), threads, from_node, use);
}

PreparedPair PairEdges::Prepare(const PairEdge& edge, const PairCalibration& calibration,
                                PartialIncrements increments) const {
  const auto attach = [&](std::size_t node, const std::optional<std::size_t>& bridge,
                          Preintegrated* partial) {
    return EndAttachment{context_.trajectory.NodePose(node), std::move(*partial),
                         bridge ? inertial_.FactorInUse(inertial_.edges()[*bridge]) : nullptr};
  };
  return PreparePair(context_.flight, calibration, edge.pair,
                     attach(edge.node_i, edge.bridge_i, &increments[0]),
                     attach(edge.node_j, edge.bridge_j, &increments[1]));
}

std::shared_ptr<const FactorBase> PairEdges::LibraryFactor(const PairEdge& edge,
                                                           const PairCalibration& calibration,
                                                           PartialIncrements increments) const {
  return MakePairFactor(context_.flight.frame, calibration,
                        Prepare(edge, calibration, std::move(increments)));
}

std::shared_ptr<const FactorBase> PairEdges::ModelFactor(const PairEdge& edge,
                                                         const PairCalibration& calibration,
                                                         PartialIncrements increments) const {
  auto factor = model_->make(context_.flight, Prepare(edge, calibration, std::move(increments)));
  if (dynamic_cast<const PointPairFactor*>(factor.get()) == nullptr) {
    throw InvalidInput(
        "pair model: the factor of the pair at t = " + std::to_string(edge.pair.t_i_s) +
        " s is not a PointPairFactor; derive its class from PointPairFactor");
  }
  return factor;
}

template <class Work>
void PairEdges::ForFactors(std::span<PairEdge> edges, const CalibrationState& calibration,
                           const Work& work) const {
  const PairCalibration pair_calibration(calibration);
  for (std::size_t first = 0; first < edges.size(); first += kPairsAtOnce) {
    const auto some = edges.subspan(first, std::min(kPairsAtOnce, edges.size() - first));
    std::vector<PartialIncrements> increments = Integrate(some, pair_calibration);
    std::vector<std::shared_ptr<const FactorBase>> made(model_ ? 0 : some.size());
    ParallelFor(static_cast<int>(made.size()), context_.threads, [&](int at) {
      const auto k = static_cast<std::size_t>(at);
      made[k] = LibraryFactor(some[k], pair_calibration, std::move(increments[k]));
    });
    for (std::size_t k = 0; k < some.size(); ++k) {
      work(some[k], [&] {
        return model_ ? ModelFactor(some[k], pair_calibration, std::move(increments[k]))
                      : std::move(made[k]);
      });
    }
  }
}

void PairEdges::Repreintegrate(const CalibrationState& calibration) {
  ForFactors(edges_, calibration, [&](const PairEdge& edge, const auto& make) {
    context_.factors.Renew(edge.id, make);
  });
}

std::vector<const double*> PairEdges::Values(std::size_t k) const {
  std::vector<const double*> x;
  for (const BlockId id : context_.net.factor(edges_[k].id).blocks) {
    x.push_back(context_.net.block(id).value.get());
  }
  return x;
}

PointSensitivity PairEdges::EndSensitivity(const PairEndIndex& end) const {
  const PairEdge& edge = edges_[end.k];
  const std::vector<const double*> x = Values(end.k);
  const auto by = [&](const FactorBase& factor) -> std::optional<PointSensitivity> {
    const auto* points = dynamic_cast<const PointPairFactor*>(&factor);
    if (points == nullptr) return std::nullopt;
    return points->SensitivityAt(end.end, x.data());
  };
  if (const auto point = by(*context_.net.factor(edge.id).factor)) return *point;
  // The blocks of a user-defined factor come after the blocks of the library's factor.
  const CalibrationState calibration = context_.calibration.State();
  const PairCalibration pair_calibration(calibration);
  return *by(*LibraryFactor(edge, pair_calibration,
                            std::move(Integrate({&edge, 1}, pair_calibration).front())));
}

Eigen::Vector3d PairEdges::Difference(std::size_t k) const {
  const std::vector<const double*> x = Values(k);
  const auto* points =
      dynamic_cast<const PointPairFactor*>(context_.net.factor(edges_[k].id).factor.get());
  if (points == nullptr) {
    throw InvalidInput("flight network: the replacement of the pair factor at t = " +
                       std::to_string(edges_[k].pair.t_i_s) +
                       " s is not a PointPairFactor; derive its class from PointPairFactor");
  }
  const auto [x_i, x_j] = points->Points(x.data());
  return x_i - x_j;
}

}  // namespace dn
