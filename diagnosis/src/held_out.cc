#include "held_out.h"

#include <dn/error.h>
#include <dn/interrupted.h>
#include <dn/parallel.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

constexpr std::size_t kMostFurther = 3;

/// Returns ln |W| of the whitening of a factor.
double LogWeight(const Network& net, const FoldFactor& factor) {
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  if (!net.EvaluateFactor(factor.id, &r, &J)) return 0.0;
  const std::vector<BlockId>& blocks = net.factor(factor.id).blocks;
  const auto at = std::find(blocks.begin(), blocks.end(), factor.measured) - blocks.begin();
  return std::log(std::abs(J[static_cast<std::size_t>(at)].determinant()));
}

/// Returns the most probable effects that the model lacks.
std::vector<FoldDensity::Further> LikeliestFurther(const NetworkFit& fit) {
  std::vector<FoldDensity::Further> further;
  const Library& library = fit.screen->library();
  for (const HypothesisEvidence& effect : fit.screen->Effects()) {
    if (further.size() >= kMostFurther) break;
    further.push_back({SelectColumns(effect, library), effect.typical});
  }
  return further;
}

/// Returns the network with an effect set constant at its assumed value. Returns nullopt if the
/// effect is not estimated.
std::optional<Network> WithoutCause(const FlightNetwork& network, const std::string& effect) {
  const std::vector<EstimateEntry>& entries = network.flight().config.estimate;
  const bool there = std::any_of(entries.begin(), entries.end(), [&](const EstimateEntry& entry) {
    return entry.unknown == effect;
  });
  if (!there) return std::nullopt;
  Network net = network.net();
  const BlockId id = net.Find(effect);
  const Eigen::VectorXd value = AssumedValue(network.flight(), effect);
  net.SetRaw(id, value.data());
  net.Hold(id);
  return net;
}

bool Active(const FoldFactor& factor, const Network& net) {
  return factor.id >= 0 && net.factor(factor.id).active;
}

/// A fold in both networks.
struct CommonFold {
  std::vector<FoldFactor> without, with;
};

std::vector<CommonFold> CommonFolds(const FlightNetwork& without, const FlightNetwork& with,
                                    int num_per_kind) {
  std::vector<CommonFold> common;
  for (const Fold& fold : MakeFolds(without, num_per_kind)) {
    const std::vector<FoldFactor> a = FindFoldFactors(fold, without);
    const std::vector<FoldFactor> b = FindFoldFactors(fold, with);
    CommonFold both;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (!Active(a[k], without.net()) || !Active(b[k], with.net())) continue;
      both.without.push_back(a[k]);
      both.with.push_back(b[k]);
    }
    if (!both.with.empty()) common.push_back(std::move(both));
  }
  return common;
}

/// Log densities of a fold; nullopt if the other data do not predict it.
struct FoldLogDensities {
  std::optional<Eigen::VectorXd> before, after;
  std::vector<std::optional<Eigen::VectorXd>> but_one;
};

HeldOutGains SumFolds(const std::vector<FoldLogDensities>& folds, std::size_t causes) {
  HeldOutGains gains;
  gains.cause_gains.resize(causes);
  Eigen::VectorXd further;
  for (const FoldLogDensities& fold : folds) {
    if (!fold.before || !fold.after) continue;
    ++gains.folds;
    gains.gain_nats += (*fold.after)[0] - (*fold.before)[0];
    const Eigen::VectorXd of_fold = fold.after->tail(fold.after->size() - 1);
    further = further.size() == 0 ? of_fold : Eigen::VectorXd(further + of_fold);
    for (std::size_t k = 0; k < fold.but_one.size(); ++k) {
      if (!fold.but_one[k]) continue;
      const double gain = (*fold.after)[0] - (*fold.but_one[k])[0];
      gains.cause_gains[k] = gains.cause_gains[k].value_or(0.0) + gain;
    }
  }
  if (causes == 1 && gains.folds > 0) gains.cause_gains[0] = gains.gain_nats;
  if (further.size() > 0) gains.further_nats = std::max(0.0, further.maxCoeff());
  return gains;
}

}  // namespace

FoldDensity::FoldDensity(const Network& net, std::vector<Further> further)
    : net_(net), further_(std::move(further)), of_all_(LogLikelihood(net)) {}

std::optional<Eigen::VectorXd> FoldDensity::LogLikelihood(const Network& net) const {
  try {
    const LinearizedNetwork linearized(net);
    const Marginals marginals(linearized);
    const Eigen::MatrixXd r = marginals.Project(linearized.residual());
    Eigen::VectorXd log_p(static_cast<Eigen::Index>(1 + further_.size()));
    log_p[0] = -0.5 * (r.squaredNorm() + marginals.LogDeterminant());
    for (std::size_t k = 0; k < further_.size(); ++k) {
      const Further& effect = further_[k];
      const Eigen::MatrixXd A = ScoreEffects(marginals, {effect.model}, {}).A;
      const Eigen::VectorXd s = TransposeTimes(linearized, effect.model, r);
      log_p[static_cast<Eigen::Index>(k) + 1] =
          SizeAveragedEvidence(A, effect.typical).LogEvidence(s);
    }
    return log_p;
  } catch (const RankDeficient&) {
    return std::nullopt;
  }
}

std::optional<Eigen::VectorXd> FoldDensity::LogDensity(
    const std::vector<FoldFactor>& factors) const {
  if (!of_all_) return std::nullopt;
  Network rest = net_;
  double log_weight = 0.0, count = 0.0;
  for (const FoldFactor& factor : factors) {
    rest.SetActive(factor.id, false);
    log_weight += LogWeight(net_, factor);
    count += net_.factor(factor.id).factor->residual_size();
  }
  const std::optional<Eigen::VectorXd> of_rest = LogLikelihood(rest);
  if (!of_rest) return std::nullopt;
  Eigen::VectorXd log_p = *of_all_ - *of_rest;
  log_p[0] += log_weight - 0.5 * count * std::log(2.0 * std::numbers::pi);
  return log_p;
}

HeldOutGains MeasureHeldOut(const NetworkFit& without, const NetworkFit& with,
                            const HeldOutOptions& options) {
  const FlightNetwork& network = with.solution->network();
  const std::vector<CommonFold> folds =
      CommonFolds(without.solution->network(), network, options.num_per_kind);
  std::vector<std::optional<Network>> but_one;
  // Without the only effect, the network is the one before.
  if (with.chosen.size() > 1) {
    for (const HypothesisEvidence& effect : with.chosen) {
      but_one.push_back(WithoutCause(network, effect.name));
    }
  }
  std::vector<std::optional<FoldDensity>> densities_but_one(but_one.size());
  for (std::size_t k = 0; k < but_one.size(); ++k) {
    if (but_one[k]) densities_but_one[k].emplace(*but_one[k], std::vector<FoldDensity::Further>{});
  }
  const FoldDensity before(without.solution->network().net(), {});
  const FoldDensity after(network.net(), LikeliestFurther(with));
  std::vector<FoldLogDensities> of_folds(folds.size());
  ParallelFor(static_cast<int>(folds.size()), options.threads, [&](int k) {
    if (options.interrupted && options.interrupted()) throw Interrupted();
    const CommonFold& fold = folds[static_cast<std::size_t>(k)];
    FoldLogDensities& out = of_folds[static_cast<std::size_t>(k)];
    out.before = before.LogDensity(fold.without);
    out.after = after.LogDensity(fold.with);
    for (const auto& density : densities_but_one) {
      out.but_one.push_back(density ? density->LogDensity(fold.with) : std::nullopt);
    }
  });
  return SumFolds(of_folds, with.chosen.size());
}

}  // namespace dn::diagnosis_internal
