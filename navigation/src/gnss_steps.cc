#include <dn/navigation/gnss_steps.h>
#include <dn/navigation/robust_scale.h>
#include <dn/solvers/robust_loss.h>
#include <dn/solvers/score_test.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <vector>

namespace dn {
namespace {

// chi-square beyond which one of some thousand tests is true: 6e-7 of three, 2e-8 of one.
constexpr double kCertain = 31.8;
// Size in sigmas of one epoch beyond which an offset is no noise.
constexpr double kRealSigmas = 4.0;
constexpr double kExplainedShare = 0.5;
constexpr std::size_t kShortestRun = 4;
constexpr std::size_t kClockSteps = 60;

struct Position {
  std::size_t edge = 0;
  FactorId id = -1;
  Eigen::Matrix3d whitening = Eigen::Matrix3d::Identity();  // d residual / d position
  Eigen::Matrix3d lever_arm = Eigen::Matrix3d::Zero();      // d residual / d lever arm
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();       // in m
  double norm2 = 0.0;
  double weight = 1.0;  // of the robust loss
};

std::vector<Position> ActivePositions(const FlightNetwork& network) {
  constexpr std::size_t kPositionBlock = 1, kLeverArmBlock = 2;
  std::vector<Position> positions;
  for (std::size_t e = 0; e < network.gnss_edges.size(); ++e) {
    const FactorId id = network.gnss_edges[e].position;
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    if (!network.net.factor(id).active || !network.net.EvaluateFactor(id, &r, &J)) continue;
    positions.push_back({e, id, J[kPositionBlock], J[kLeverArmBlock],
                         network.NodePose(network.gnss_edges[e].node).v_m, r.squaredNorm(),
                         EvaluateLoss(network.net.factor(id).loss, r.squaredNorm()).rho_prime});
  }
  return positions;
}

double Scale(const std::vector<Position>& positions) {
  std::vector<double> norm2;
  for (const Position& position : positions) norm2.push_back(position.norm2);
  return RobustVariance(norm2);
}

struct Run {
  std::size_t first, past;  // of the positions
};

// Runs between any two of the places before and after the given positions.
std::vector<Run> RunsBetween(const std::vector<Position>& positions,
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

// A tag that is late by dt belongs to the position of dt before.
EffectModel LateTags(const std::vector<Position>& positions, std::size_t first) {
  EffectModel effect;
  for (std::size_t k = first; k < positions.size(); ++k) {
    const Position& position = positions[k];
    effect.push_back(
        {position.id, Eigen::MatrixXd(Eigen::Vector3d(-position.whitening * position.velocity))});
  }
  return effect;
}

EffectModel LeverArm(const std::vector<Position>& positions) {
  EffectModel effect;
  for (const Position& position : positions) {
    effect.push_back({position.id, Eigen::MatrixXd(position.lever_arm)});
  }
  return effect;
}

/// Causes to be tested, each with how far it would move a typical position by its estimate.
struct Suspects {
  std::vector<GnssMisfit> causes;
  std::vector<EffectModel> effects;
};

Suspects AllSuspects(const FlightNetwork& network, const std::vector<Position>& positions) {
  Suspects suspects;
  const auto add = [&](GnssMisfit::Cause cause, std::size_t first, EffectModel effect) {
    suspects.causes.push_back({cause, {}, 0.0, positions[first].edge});
    suspects.effects.push_back(std::move(effect));
  };
  if (network.net.block(network.gnss_lever_arm.id).held) {
    add(GnssMisfit::Cause::kLeverArm, 0, LeverArm(positions));
  }
  add(GnssMisfit::Cause::kTimeOffset, 0, LateTags(positions, 0));
  const std::size_t hop = std::max<std::size_t>(1, positions.size() / kClockSteps);
  for (std::size_t first = hop; first + kShortestRun <= positions.size(); first += hop) {
    add(GnssMisfit::Cause::kClockStep, first, LateTags(positions, first));
  }
  return suspects;
}

// Root mean square, in sigmas, of what the estimate adds to the residuals.
double Moved(const EffectModel& effect, const Eigen::VectorXd& estimate) {
  double sum = 0.0;
  for (const EffectPart& part : effect) sum += (part.L * estimate).squaredNorm();
  return std::sqrt(sum / static_cast<double>(effect.size()));
}

/// The run whose common offset is the most significant one.
class JumpSearch {
 public:
  JumpSearch(const FlightNetwork& network, const Marginals& marginals,
             const std::vector<Position>& positions)
      : network_(network),
        marginals_(marginals),
        positions_(positions),
        least_(kCertain * Scale(positions)) {}

  void Try(const std::vector<Run>& runs) {
    std::vector<EffectModel> effects;
    for (const Run& run : runs) {
      EffectModel effect;
      for (std::size_t k = run.first; k < run.past; ++k) {
        effect.push_back({positions_[k].id, Eigen::MatrixXd(positions_[k].whitening)});
      }
      effects.push_back(std::move(effect));
    }
    const std::vector<ScoreTest> tests = TestEffects(network_.net, marginals_, effects);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const bool real = Moved(effects[i], tests[i].estimate) > kRealSigmas;
      if (tests[i].statistic <= least_ || !real) continue;
      least_ = tests[i].statistic;
      run_ = runs[i];
      best_ = GnssJump{positions_[run_.first].edge, positions_[run_.past - 1].edge,
                       tests[i].estimate, tests[i].statistic};
    }
  }

  // Moves both ends by halved steps as long as that makes the offset more significant.
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
  const FlightNetwork& network_;
  const Marginals& marginals_;
  const std::vector<Position>& positions_;
  double least_;
  Run run_{0, 0};
  std::optional<GnssJump> best_;
};

}  // namespace

std::optional<GnssJump> FindGnssJump(const FlightNetwork& network, const Marginals& marginals,
                                     const std::vector<FactorId>& ends) {
  const std::vector<Position> positions = ActivePositions(network);
  if (positions.size() < 2 * kShortestRun) return std::nullopt;
  JumpSearch search(network, marginals, positions);
  search.Try(RunsBetween(positions, ends));
  search.Refine();
  return search.best();
}

std::optional<GnssMisfit> ExplainGnssMisfit(const FlightNetwork& network,
                                            const Marginals& marginals) {
  const std::vector<Position> positions = ActivePositions(network);
  if (positions.size() < 2 * kShortestRun) return std::nullopt;
  const Suspects suspects = AllSuspects(network, positions);
  const std::vector<ScoreTest> tests = TestEffects(network.net, marginals, suspects.effects);
  double excess = -3.0 * static_cast<double>(positions.size());
  for (const Position& position : positions) excess += position.weight * position.norm2;
  double least = std::max(kCertain * Scale(positions), kExplainedShare * excess);
  std::optional<GnssMisfit> best;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (tests[i].statistic <= least) continue;
    if (Moved(suspects.effects[i], tests[i].estimate) <= kRealSigmas) continue;
    least = tests[i].statistic;
    best = suspects.causes[i];
    best->estimate = tests[i].estimate;
    best->statistic = tests[i].statistic;
  }
  return best;
}

}  // namespace dn
