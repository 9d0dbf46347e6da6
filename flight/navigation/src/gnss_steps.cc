#include <dn/navigation/gnss_steps.h>
#include <dn/navigation/robust_scale.h>
#include <dn/solvers/score_test.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace dn {
namespace {

// chi-square threshold for a decisive result among some thousand tests: probability 6e-7 for three
// degrees of freedom, 2e-8 for one.
constexpr double kCertain = 31.8;
// Size of an offset, in sigmas of one epoch, that noise does not explain.
constexpr double kRealSigmas = 4.0;
// Fraction of the excess of the squared residuals that a cause must explain.
constexpr double kExplainedShare = 0.5;
constexpr std::size_t kShortestRun = 4;
constexpr std::size_t kClockSteps = 60;

struct ActivePosition {
  std::size_t edge = 0;
  FactorId id = -1;
  Eigen::Matrix3d whitening = Eigen::Matrix3d::Identity();  // d residual / d position
  Eigen::Matrix3d lever_arm = Eigen::Matrix3d::Zero();      // d residual / d lever arm
  double norm2 = 0.0;
};

std::vector<ActivePosition> ActivePositions(const FlightNetwork& network,
                                            const LinearizedNetwork& linearized) {
  constexpr std::size_t kPositionBlock = 1, kLeverArmBlock = 2;
  std::vector<ActivePosition> positions;
  for (std::size_t e = 0; e < network.gnss().edges().size(); ++e) {
    const FactorId id = network.gnss().edges()[e].position;
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    if (!linearized.FindRows(id) || !network.net().EvaluateFactor(id, &r, &J)) continue;
    positions.push_back({e, id, J[kPositionBlock], J[kLeverArmBlock], r.squaredNorm()});
  }
  return positions;
}

/// Returns the excess of the sum of squared residuals over its expectation.
double Excess(const LinearizedNetwork& linearized) {
  return linearized.residual().squaredNorm() -
         static_cast<double>(linearized.rows() - linearized.parameters());
}

double Scale(const std::vector<ActivePosition>& positions) {
  std::vector<double> norm2;
  for (const ActivePosition& position : positions) norm2.push_back(position.norm2);
  return RobustVariance(norm2);
}

struct Run {
  std::size_t first, past;  // indices into the positions
};

// Returns the runs of positions that begin and end directly before or after one of the given
// positions, at most half of all positions long.
std::vector<Run> RunsBetween(const std::vector<ActivePosition>& positions,
                             const std::vector<FactorId>& ends) {
  std::set<std::size_t> places;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    if (std::find(ends.begin(), ends.end(), positions[k].id) == ends.end()) continue;
    places.insert({k, k + 1});
  }
  std::vector<Run> runs;
  for (auto first = places.begin(); first != places.end(); ++first) {
    for (auto past = std::next(first); past != places.end(); ++past) {
      if (2 * (*past - *first) <= positions.size()) runs.push_back({*first, *past});
    }
  }
  return runs;
}

constexpr EffectId kOffset = EffectId::kGnssTimeOffset, kDrift = EffectId::kGnssTimeDrift;

bool IsUnknown(const FlightNetwork& network, EffectId effect) {
  return std::any_of(network.calibration().effects().begin(), network.calibration().effects().end(),
                     [&](const EffectBlock& one) { return IsEffect(one.name, effect); });
}

/// Derivatives of the GNSS edges with respect to an offset and a drift of the clock at their
/// present values.
class ClockModel {
 public:
  explicit ClockModel(const FlightNetwork& network)
      : network_(network), state_(network.calibration().State()) {
    for (const EffectId effect : {kOffset, kDrift}) {
      if (IsUnknown(network, effect)) continue;
      state_.Insert({EffectName(effect), FindEstimable(effect)->make({network.flight()}),
                     Eigen::VectorXd::Zero(1)});
    }
    for (std::size_t e = 0; e < network.gnss().edges().size(); ++e) {
      const GnssEdge& edge = network.gnss().edges()[e];
      Add(e, edge.position, *network.gnss().PositionFactor(edge, state_),
          network.trajectory().gnss_error());
      if (edge.velocity < 0) continue;
      Add(e, edge.velocity, *network.gnss().VelocityFactor(edge, state_), {});
    }
  }

  /// Returns the model of both; columns: offset, drift.
  const EffectModel& both() const { return model_; }

  /// Returns the model of an offset that begins at an edge.
  EffectModel OffsetFrom(std::size_t edge) const {
    EffectModel late;
    for (std::size_t k = 0; k < model_.size(); ++k) {
      if (edge_[k] >= edge) late.push_back({model_[k].factor, model_[k].L.leftCols<1>()});
    }
    return late;
  }

 private:
  void Add(std::size_t e, FactorId id, const FactorBase& factor,
           const std::vector<ProcessChain>& errors) {
    if (!network_.net().factor(id).active) return;
    const GnssEdge& edge = network_.gnss().edges()[e];
    const NodeBlocks& node = network_.nodes()[edge.node];
    std::vector<const double*> x;
    for (const BlockId block :
         {node.q_mb.id, node.p_mb.id, network_.calibration().gnss_lever_arm().id, node.v_m.id}) {
      x.push_back(Value(block));
    }
    const double tag_s = network_.flight().gnss->epochs[edge.epoch].t_s;
    for (const ProcessChain& chain : errors) x.push_back(Value(chain.At(tag_s).id));
    std::vector<std::size_t> columns;
    for (const std::size_t k : GnssEffectIndices(state_)) {
      const CalibrationValue& effect = state_.effects[k];
      const bool of_clock = IsEffect(effect.name, kOffset) || IsEffect(effect.name, kDrift);
      if (of_clock) columns.push_back(x.size());
      x.push_back(effect.value.data());
    }
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    if (!EvaluateInTangent(factor, x, &r, &J)) return;
    Eigen::MatrixXd L(r.size(), 2);
    L << J[columns[0]], J[columns[1]];
    model_.push_back({id, std::move(L)});
    edge_.push_back(e);
  }

  const double* Value(BlockId id) const { return network_.net().block(id).value.get(); }

  const FlightNetwork& network_;
  CalibrationState state_;
  EffectModel model_;
  std::vector<std::size_t> edge_;  // index of the edge of each part of model_
};

EffectModel LeverArm(const std::vector<ActivePosition>& positions) {
  EffectModel effect;
  for (const ActivePosition& position : positions) {
    effect.push_back({position.id, Eigen::MatrixXd(position.lever_arm)});
  }
  return effect;
}

/// Causes to be tested with the models of their effects.
struct Suspects {
  std::vector<GnssMisfit> causes;
  std::vector<EffectModel> effects;
};

Suspects AllSuspects(const FlightNetwork& network, const std::vector<ActivePosition>& positions,
                     bool clock_may_step) {
  Suspects suspects;
  const auto add = [&](GnssMisfit::Cause cause, std::size_t first, EffectModel effect) {
    suspects.causes.push_back({cause, {}, 0.0, positions[first].edge});
    suspects.effects.push_back(std::move(effect));
  };
  if (network.net().block(network.calibration().gnss_lever_arm().id).held) {
    add(GnssMisfit::Cause::kLeverArm, 0, LeverArm(positions));
  }
  const ClockModel clock(network);
  const bool unknown = IsUnknown(network, kOffset) && IsUnknown(network, kDrift);
  if (!unknown) add(GnssMisfit::Cause::kClock, 0, clock.both());
  if (!clock_may_step) return suspects;
  const std::size_t hop = StepSpacing(positions.size());
  for (std::size_t first = hop; first + kShortestRun <= positions.size(); first += hop) {
    add(GnssMisfit::Cause::kClockStep, first, clock.OffsetFrom(positions[first].edge));
  }
  return suspects;
}

// Returns the root mean square of the change that the estimate makes to the residuals, in sigmas.
double Moved(const EffectModel& effect, const Eigen::VectorXd& estimate) {
  double sum = 0.0;
  for (const EffectPart& part : effect) sum += (part.L * estimate).squaredNorm();
  return std::sqrt(sum / static_cast<double>(effect.size()));
}

// Returns the root mean square, in sigmas, of the change that an offset of the positions of a run
// makes to the residuals.
double Moved(const std::vector<ActivePosition>& positions, const Run& run,
             const Eigen::Vector3d& offset_m) {
  double sum = 0.0;
  for (std::size_t k = run.first; k < run.past; ++k) {
    sum += (positions[k].whitening * offset_m).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(run.past - run.first));
}

/// Tests for a common offset of the positions of each run. The offset of a run is an offset from
/// its start on minus one from its end on. The offsets from n places therefore suffice for all n (n
/// - 1) / 2 runs.
class OffsetsFromPlaces {
 public:
  OffsetsFromPlaces(const Marginals& marginals, const std::vector<ActivePosition>& positions,
                    const std::vector<Run>& runs) {
    for (const Run& run : runs) {
      for (const std::size_t place : {run.first, run.past}) component_.emplace(place, 0);
    }
    std::vector<EffectModel> effects;
    for (auto& [place, component] : component_) {
      component = 3 * static_cast<Eigen::Index>(effects.size());
      EffectModel effect;
      for (std::size_t k = place; k < positions.size(); ++k) {
        effect.push_back({positions[k].id, Eigen::MatrixXd(positions[k].whitening)});
      }
      if (!effect.empty()) effects.push_back(std::move(effect));
    }
    of_offsets_ = ScoreEffects(marginals, effects, {});
  }

  ScoreTest During(const Run& run) const {
    const Eigen::Index a = component_.at(run.first), b = component_.at(run.past);
    const JointScore& all = of_offsets_;
    Eigen::Vector3d s = all.s.segment<3>(a), signature2 = all.signature2.segment<3>(a);
    Eigen::Matrix3d A = all.A.block<3, 3>(a, a);
    if (b < all.s.size()) {
      s -= all.s.segment<3>(b);
      signature2 -= all.signature2.segment<3>(b);
      A += all.A.block<3, 3>(b, b) - all.A.block<3, 3>(a, b) - all.A.block<3, 3>(b, a);
    }
    return TestScore(s, A, signature2);
  }

 private:
  std::map<std::size_t, Eigen::Index> component_;  // first component of a place
  JointScore of_offsets_;
};

/// Searches the run with the most significant common offset.
class JumpSearch {
 public:
  JumpSearch(const Marginals& marginals, const std::vector<ActivePosition>& positions,
             double noise_ratio)
      : marginals_(marginals),
        positions_(positions),
        least_(kCertain * noise_ratio * Scale(positions)),
        real_(kRealSigmas * std::sqrt(noise_ratio)) {}

  void Try(const std::vector<Run>& runs) {
    const OffsetsFromPlaces offsets(marginals_, positions_, runs);
    for (const Run& run : runs) {
      const ScoreTest test = offsets.During(run);
      const bool real = Moved(positions_, run, test.estimate) > real_;
      if (test.statistic <= least_ || !real) continue;
      least_ = test.statistic;
      run_ = run;
      best_ = GnssJump{positions_[run_.first].edge, positions_[run_.past - 1].edge, test.estimate,
                       test.statistic};
    }
  }

  // Moves both ends, with the step halved each time, as long as the offset becomes more
  // significant.
  void Refine() {
    if (!best_) return;
    for (std::size_t step = (run_.past - run_.first) / 2; step > 0; step /= 2) {
      const Run at = run_;
      std::vector<Run> moved;
      for (const std::size_t first :
           {at.first, at.first + step, at.first - std::min(at.first, step)}) {
        for (const std::size_t past :
             {at.past, at.past - step, std::min(positions_.size(), at.past + step)}) {
          if (past > first) moved.push_back({first, past});
        }
      }
      Try(moved);
    }
  }

  const std::optional<GnssJump>& best() const { return best_; }

 private:
  const Marginals& marginals_;
  const std::vector<ActivePosition>& positions_;
  double least_, real_;
  Run run_{0, 0};
  std::optional<GnssJump> best_;
};

}  // namespace

std::optional<GnssJump> FindGnssJump(const FlightNetwork& network, const Marginals& marginals,
                                     const std::vector<FactorId>& ends, double noise_ratio) {
  const std::vector<ActivePosition> positions = ActivePositions(network, marginals.linearized());
  if (positions.size() < 2 * kShortestRun) return std::nullopt;
  JumpSearch search(marginals, positions, noise_ratio);
  search.Try(RunsBetween(positions, ends));
  search.Refine();
  return search.best();
}

std::size_t StepSpacing(std::size_t epochs) {
  return std::max<std::size_t>(1, epochs / kClockSteps);
}

std::optional<GnssMisfit> ExplainGnssMisfit(const FlightNetwork& network,
                                            const Marginals& marginals, bool clock_may_step) {
  const std::vector<ActivePosition> positions = ActivePositions(network, marginals.linearized());
  if (positions.size() < 2 * kShortestRun) return std::nullopt;
  const Suspects suspects = AllSuspects(network, positions, clock_may_step);
  const std::vector<ScoreTest> tests = TestEffects(marginals, suspects.effects);
  const double enough =
      std::max(kCertain * Scale(positions), kExplainedShare * Excess(marginals.linearized()));
  std::optional<GnssMisfit> best;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const GnssMisfit& suspect = suspects.causes[i];
    const bool clock = suspect.cause == GnssMisfit::Cause::kClock;
    if (tests[i].statistic <= (clock ? kCertain : enough)) continue;
    if (best && tests[i].statistic <= best->statistic) continue;
    if (best && best->cause == GnssMisfit::Cause::kClock) break;
    if (!clock && Moved(suspects.effects[i], tests[i].estimate) <= kRealSigmas) continue;
    best = suspect;
    best->estimate = tests[i].estimate;
    best->statistic = tests[i].statistic;
  }
  return best;
}

}  // namespace dn
