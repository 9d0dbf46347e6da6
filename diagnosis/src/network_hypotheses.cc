#include "network_hypotheses.h"

#include <dn/autodiff.h>
#include <dn/effects/effect_table.h>
#include <dn/files/scanners.h>
#include <dn/imu/imu_means.h>
#include <dn/parallel.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <span>

#include "pair_columns.h"
#include "time_cells.h"

namespace dn::diagnosis_internal {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t kMaxStepTimes = 6;
// The samples are averaged over intervals of this length before they are used in derivatives.
constexpr double kMeanInterval_s = 0.02;

/// Returns times between strips, in their order, at which the mount may have slipped; six at most.
std::vector<double> StepTimes(const std::vector<StripInterval>& strips) {
  std::vector<double> t_s;
  for (std::size_t k = 1; k < strips.size(); ++k) {
    t_s.push_back(0.5 * (strips[k - 1].t1_s + strips[k].t0_s));
  }
  if (t_s.size() > kMaxStepTimes) {
    std::vector<double> some;
    for (std::size_t k = 0; k < kMaxStepTimes; ++k)
      some.push_back(t_s[k * t_s.size() / kMaxStepTimes]);
    return some;
  }
  return t_s;
}

/// Edges of one kind, with the factor that they would have under a calibration with all hypotheses.
struct EdgeKind {
  std::vector<FactorId> edges;
  std::vector<std::size_t> effects;  ///< effects in the order of the factor's last blocks
  /// Number of last blocks of the network's factor that are effects of the network. It is absent
  /// for GNSS edges without the block of the velocity.
  std::optional<std::size_t> own_effects = {};
  std::vector<std::size_t> nodes;  ///< nodes of GNSS edges
  std::function<std::shared_ptr<const FactorBase>(std::size_t)> make;
};

/// Adds every hypothesis to the edges, with the value zero, and computes the derivatives.
class NetworkHypotheses {
 public:
  NetworkHypotheses(const FlightNetwork& network, int threads,
                    const std::vector<Hypothesis>& discrepancies)
      : network_(network),
        threads_(threads),
        means_(AverageSamples(*network.flight().imu, kMeanInterval_s)),
        state_(network.calibration().State()),
        num_discrepancies_(discrepancies.size()) {
    for (const EstimableEffect& effect : EstimableEffects()) Add(effect);
    for (const Hypothesis& discrepancy : discrepancies) AddAtZero(discrepancy);
    state_columns_.assign(state_.effects.size(), nullptr);
  }

  Library Run() {
    MatchStates();
    MakeBridgingEdges();
    AddInertial();
    AddGnss();
    AddPairs();
    AddControl(network_.control());
    AddControl(network_.ties());
    AddControl(network_.surfaces());
    Library out;
    const std::size_t first_discrepancy = found_.hypotheses.size() - num_discrepancies_;
    for (std::size_t k = 0; k < found_.hypotheses.size(); ++k) {
      if (k < first_discrepancy && found_.blocks[k].empty()) continue;
      out.Add(std::move(found_.hypotheses[k]), std::move(found_.blocks[k]));
    }
    return out;
  }

 private:
  void Add(const EstimableEffect& effect) {
    const EffectSpec& spec = EffectRow(effect.id);
    const bool of_lidar = spec.sensor == EffectSensor::kLidar;
    if (of_lidar ? network_.pairs().edges().empty()
                 : spec.sensor == EffectSensor::kGnss && network_.gnss().edges().empty()) {
      return;
    }
    const std::size_t sites = of_lidar ? NumScanners(network_.flight().config) : 1;
    for (std::size_t scanner = 0; scanner < sites; ++scanner) Add(effect, spec, scanner);
  }

  void Add(const EstimableEffect& effect, const EffectSpec& spec, std::size_t scanner) {
    EffectSite site{network_.flight(), {}, scanner};
    if (spec.timing == EffectTiming::kStart) {
      for (const double t0_s : StepTimes(InTime(FindStrips(network_.flight())))) {
        site.times.t0_s = t0_s;
        AddAtZero(MakeHypothesis(effect, site));
      }
    } else if (spec.timing == EffectTiming::kFlight && !InNetwork(effect, scanner)) {
      AddAtZero(MakeHypothesis(effect, site));
    }
  }

  /// Returns whether the network corrects for the effect. A block that every network has does so
  /// only if it is estimated; otherwise the hypothesis is the change from its constant value.
  bool InNetwork(const EstimableEffect& effect, std::size_t scanner) const {
    const std::string name = ScannerName(network_.flight().config, effect.name(), scanner);
    const Network& net = network_.net();
    if (effect.configured != nullptr) return !net.block(net.Find(name)).held;
    return std::any_of(network_.calibration().effects().begin(),
                       network_.calibration().effects().end(),
                       [&](const EffectBlock& block) { return block.name == name; });
  }

  void AddAtZero(const Hypothesis& hypothesis) {
    at_zero_.push_back(found_.hypotheses.size());
    state_.Insert(
        {hypothesis.name, hypothesis.action, Eigen::VectorXd::Zero(hypothesis.typical.size())});
    found_.Add(hypothesis, {});
  }

  /// Assigns columns to each effect of the state. Both lists have the order of EstimableEffects;
  /// the state also has the effects of the network.
  void MatchStates() {
    auto next = at_zero_.begin();
    for (std::size_t k = 0; k < state_.effects.size(); ++k) {
      const bool own = OwnBlock(k) >= 0;
      state_columns_[k] = own ? nullptr : &found_.blocks[*next++];
    }
  }

  /// Returns the block of the network for an effect of the state; -1 for a hypothesis.
  BlockId OwnBlock(std::size_t k) const {
    const CalibrationValue& value = state_.effects[k];
    const bool first =
        std::none_of(state_.effects.begin(), state_.effects.begin() + static_cast<long>(k),
                     [&](const CalibrationValue& before) { return before.name == value.name; });
    for (const EffectBlock& effect : network_.calibration().effects()) {
      if (first && effect.name == value.name) return effect.id;
    }
    return -1;
  }

  void AddInertial() {
    EdgeKind kind;
    for (const auto& edge : network_.inertial().edges()) kind.edges.push_back(edge.id);
    kind.effects = InertialEffectIndices(state_);
    kind.own_effects = InertialEffectIndices(network_.calibration().State()).size();
    kind.make = [&](std::size_t k) { return bridging_[k] ? bridging_[k] : InertialFactor(k); };
    Differentiate(kind);
  }

  /// Makes the factors of inertial edges that pairs and control use; AddInertial and AddPairs need
  /// them, too.
  void MakeBridgingEdges() {
    std::set<std::size_t> edges;
    for (const PairEdge& edge : network_.pairs().edges()) {
      if (edge.bridge_i) edges.insert(*edge.bridge_i);
      if (edge.bridge_j) edges.insert(*edge.bridge_j);
    }
    for (const ControlEdges* all : {&network_.control(), &network_.ties(), &network_.surfaces()}) {
      for (const ControlEdge& edge : all->edges()) {
        if (edge.bridge) edges.insert(*edge.bridge);
      }
    }
    bridging_.resize(network_.inertial().edges().size());
    const std::vector<std::size_t> all(edges.begin(), edges.end());
    ParallelFor(static_cast<int>(all.size()), threads_, [&](int k) {
      const std::size_t edge = all[static_cast<std::size_t>(k)];
      bridging_[edge] = InertialFactor(edge);
    });
  }

  std::shared_ptr<const PreintegratedInertial> InertialFactor(std::size_t edge) const {
    return network_.inertial().FactorByMeans(network_.inertial().edges()[edge], state_, means_);
  }

  void AddGnss() {
    EdgeKind position, velocity;
    std::vector<const GnssEdge*> with_velocity;
    for (const auto& edge : network_.gnss().edges()) {
      position.edges.push_back(edge.position);
      position.nodes.push_back(edge.node);
      if (edge.velocity < 0) continue;
      with_velocity.push_back(&edge);
      velocity.edges.push_back(edge.velocity);
      velocity.nodes.push_back(edge.node);
    }
    if (!network_.trajectory().gnss_error().empty()) {
      position.own_effects = GnssEffectIndices(network_.calibration().State()).size();
    }
    position.effects = velocity.effects = GnssEffectIndices(state_);
    position.make = [&](std::size_t k) {
      return network_.gnss().PositionFactor(network_.gnss().edges()[k], state_);
    };
    velocity.make = [&](std::size_t k) {
      return network_.gnss().VelocityFactor(*with_velocity[k], state_);
    };
    Differentiate(position);
    Differentiate(velocity);
  }

  void AddPairs() {
    if (network_.pairs().edges().empty()) return;
    std::vector<FactorId> edges;
    for (const auto& edge : network_.pairs().edges()) edges.push_back(edge.id);
    std::vector<Eigen::Matrix3Xd> whole;
    for (const auto& inertial : bridging_) {
      whole.emplace_back();
      if (inertial) whole.back() = inertial->increments().J_effects.topRows<3>();
    }
    const std::vector<Eigen::Matrix3Xd> columns =
        PairColumns(network_, state_, means_, whole, threads_);
    Append(edges, PairEffectIndices(state_), columns);
  }

  void AddControl(const ControlEdges& control) {
    const std::vector<ControlEdge>& edges = control.edges();
    EdgeKind kind;
    for (const ControlEdge& edge : edges) kind.edges.push_back(edge.id);
    kind.effects = PairEffectIndices(state_);
    kind.own_effects = PairEffectIndices(network_.calibration().State()).size();
    kind.make = [&](std::size_t k) {
      return control.Factor(edges[k], state_,
                            edges[k].bridge ? bridging_[*edges[k].bridge] : nullptr);
    };
    Differentiate(kind);
  }

  /// Returns the values for the factor that an edge would have under the extended calibration.
  std::vector<const double*> FactorValues(const EdgeKind& kind, std::size_t k) const {
    std::vector<const double*> x;
    if (kind.own_effects) {
      const std::vector<BlockId>& blocks = network_.net().factor(kind.edges[k]).blocks;
      const std::size_t others = blocks.size() - *kind.own_effects;
      for (std::size_t b = 0; b < others; ++b) x.push_back(Value(blocks[b]));
    } else {
      const NodeBlocks& node = network_.nodes()[kind.nodes[k]];
      x = {Value(node.q_mb.id), Value(node.p_mb.id),
           Value(network_.calibration().gnss_lever_arm().id), Value(node.v_m.id)};
    }
    for (const std::size_t e : kind.effects) x.push_back(state_.effects[e].value.data());
    return x;
  }

  const double* Value(BlockId id) const { return network_.net().block(id).value.get(); }

  /// Returns the derivative of an edge's residual by the effects, one block of columns after
  /// another. It is empty for an inactive edge.
  Eigen::MatrixXd EffectDerivatives(const EdgeKind& kind, std::size_t k) const {
    const FactorRecord& record = network_.net().factor(kind.edges[k]);
    if (!record.active) return {};
    const std::shared_ptr<const FactorBase> factor = kind.make(k);
    const int rows = factor->residual_size();
    if (rows != record.factor->residual_size()) return {};  // the user replaced the factor
    const std::vector<BlockKind>& blocks = factor->block_kinds();
    const std::span of_effects = std::span(blocks).last(kind.effects.size());
    int columns = 0;
    for (const BlockKind& block : of_effects) columns += block.stored_size;
    // Effects are vectors: their stored coordinates are the tangent ones.
    std::vector<double> stored(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns),
                               UnwrittenNan());
    std::vector<double*> J(blocks.size(), nullptr);
    double* next = stored.data();
    for (std::size_t b = 0; b < of_effects.size(); ++b) {
      J[blocks.size() - of_effects.size() + b] = next;
      next += rows * of_effects[b].stored_size;
    }
    Eigen::VectorXd r(rows);
    if (!factor->Evaluate(FactorValues(kind, k).data(), r.data(), J.data())) return {};
    return JoinBlocks(stored.data(), rows, columns, of_effects);
  }

  static Eigen::MatrixXd JoinBlocks(const double* stored, int rows, int columns,
                                    std::span<const BlockKind> blocks) {
    Eigen::MatrixXd L(rows, columns);
    Eigen::Index column = 0;
    for (const BlockKind& block : blocks) {
      L.middleCols(column, block.stored_size) =
          Eigen::Map<const RowMajor>(stored, rows, block.stored_size);
      stored += rows * block.stored_size;
      column += block.stored_size;
    }
    return L;
  }

  bool AnyHypothesis(const std::vector<std::size_t>& effects) const {
    return std::any_of(effects.begin(), effects.end(),
                       [&](std::size_t e) { return state_columns_[e] != nullptr; });
  }

  void Differentiate(const EdgeKind& kind) {
    if (!AnyHypothesis(kind.effects)) return;
    std::vector<Eigen::MatrixXd> derivatives(kind.edges.size());
    ParallelFor(static_cast<int>(derivatives.size()), threads_, [&](int at) {
      const auto k = static_cast<std::size_t>(at);
      derivatives[k] = EffectDerivatives(kind, k);
    });
    Append(kind.edges, kind.effects, derivatives);
  }

  /// Appends the derivatives of edges to the hypotheses.
  template <class Matrix>
  void Append(const std::vector<FactorId>& edges, const std::vector<std::size_t>& effects,
              const std::vector<Matrix>& derivatives) {
    std::vector<Eigen::Index> first{0};
    for (const std::size_t e : effects) {
      first.push_back(first.back() + state_.effects[e].value.size());
    }
    ParallelFor(static_cast<int>(effects.size()), threads_, [&](int at) {
      const auto k = static_cast<std::size_t>(at);
      EffectModel* const columns = state_columns_[effects[k]];
      if (columns == nullptr) return;
      AppendColumns(edges, derivatives, first[k], first[k + 1] - first[k], columns);
    });
  }

  template <class Matrix>
  static void AppendColumns(const std::vector<FactorId>& edges,
                            const std::vector<Matrix>& derivatives, Eigen::Index first,
                            Eigen::Index count, EffectModel* columns) {
    columns->reserve(columns->size() + derivatives.size());
    for (std::size_t k = 0; k < derivatives.size(); ++k) {
      if (derivatives[k].size() == 0) continue;
      columns->push_back({edges[k], derivatives[k].middleCols(first, count)});
    }
  }

  const FlightNetwork& network_;
  int threads_;
  ImuData means_;
  CalibrationState state_;
  std::size_t num_discrepancies_;
  Library found_;
  std::vector<std::size_t> at_zero_;         // indices into found_ of the hypotheses in the state
  std::vector<EffectModel*> state_columns_;  // one per effect of the state; null: estimated
  // Null: no pair uses the edge.
  std::vector<std::shared_ptr<const PreintegratedInertial>> bridging_;
};

}  // namespace

Library MakeNetworkHypotheses(const FlightNetwork& network, int threads,
                              const std::vector<Hypothesis>& discrepancies) {
  return NetworkHypotheses(network, threads, discrepancies).Run();
}

}  // namespace dn::diagnosis_internal
