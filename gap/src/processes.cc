#include "processes.h"

#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/gap/adapt.h>
#include <dn/log_sum.h>
#include <dn/solvers/restricted_likelihood.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "network_beside.h"

namespace dn::internal {
namespace {

constexpr double kProcessTausS[] = {4.0, 15.0, 60.0, 240.0};
// Powers of ten of the size, relative to the usual one, and how likely each is.
constexpr double kPowers[] = {-1.0, -0.5, 0.0, 0.5, 1.0};
constexpr double kWeights[] = {0.1, 0.2, 0.4, 0.2, 0.1};
// Share of the sigma at which a process is as good as absent.
constexpr double kAbsent = 1e-3;

const ProcessChain& NewestChain(const FlightNetwork& network, const std::string& effect) {
  if (effect == "gyro_bias_process") return network.gyro_bias.back();
  if (effect == "accel_bias_process") return network.accel_bias.back();
  return network.gnss_error.back();
}

/// 1 for the rows that state the size of a chain.
Eigen::VectorXd RowsOfChain(const FlightNetwork& network, const LinearizedNetwork& linearized,
                            const ProcessChain& chain) {
  std::set<BlockId> blocks;
  for (const auto& block : chain.blocks) blocks.insert(block.id);
  Eigen::VectorXd share = Eigen::VectorXd::Zero(linearized.rows());
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    const FactorGroup::Kind kind = linearized.group(rows.factor).kind;
    if (kind == FactorGroup::Kind::kMeasurement) continue;
    const std::vector<BlockId>& of = network.net.factor(rows.factor).blocks;
    const bool inside =
        std::all_of(of.begin(), of.end(), [&](BlockId id) { return blocks.count(id) > 0; });
    if (inside) share.segment(rows.first, rows.count).setOnes();
  }
  return share;
}

struct AtTau {
  double tau_s = 0.0;
  double log_evidence = 0.0;
  double best_log_likelihood = 0.0;
  double size = 1.0;  ///< of the likeliest sigma, in usual ones
  double relative_sigma = 0.3;
};

/// The parabola through the best of equally spaced points and its neighbours.
void RefineSize(const std::vector<double>& l, std::size_t best, double step, AtTau* at) {
  if (best == 0 || best + 1 >= l.size()) return;
  const double slope = (l[best + 1] - l[best - 1]) / (2.0 * step);
  const double curvature = (2.0 * l[best] - l[best - 1] - l[best + 1]) / (step * step);
  if (!(curvature > 0.0)) return;
  at->size *= std::pow(10.0, std::clamp(slope / curvature, -step, step));
  at->relative_sigma = std::log(10.0) / std::sqrt(curvature);
}

AtTau Judge(const FlightNetwork& network, const std::string& effect, double tau_s, int threads) {
  const Marginals marginals(network.net, {.threads = threads});
  const Eigen::VectorXd share =
      RowsOfChain(network, marginals.linearized(), NewestChain(network, effect));
  constexpr double kLogStep = 0.25;
  std::vector<double> thetas{kAbsent * kAbsent - 1.0};
  for (double power = -1.5; power <= 1.5 + 1e-9; power += kLogStep) {
    thetas.push_back(std::pow(10.0, 2.0 * power) - 1.0);
  }
  const VarianceProfile profile = ProfileVariance(marginals.linearized(), share, thetas, threads);
  std::vector<double> l;
  for (std::size_t k = 1; k < thetas.size(); ++k) {
    l.push_back(profile.log_likelihood_ratio[k] - profile.log_likelihood_ratio[0]);
  }
  AtTau at;
  at.tau_s = tau_s;
  const auto best = static_cast<std::size_t>(std::max_element(l.begin(), l.end()) - l.begin());
  at.best_log_likelihood = l[best];
  at.size = std::pow(10.0, -1.5 + kLogStep * static_cast<double>(best));
  RefineSize(l, best, kLogStep, &at);
  double sum = 0.0;
  for (int g = 0; g < 5; ++g) {
    const auto k = static_cast<std::size_t>(std::lround((kPowers[g] + 1.5) / kLogStep));
    sum += kWeights[g] * std::exp(l[k] - l[best]);
  }
  // Between the five sizes the likelihood may have its peak: they are taken as wide as their steps.
  const double peak = std::min(1.0, at.relative_sigma / std::log(10.0) / 0.5) * 0.2;
  at.log_evidence = l[best] + std::log(std::max({sum, peak, 1e-300}));
  return at;
}

/// Where a parabola through the likeliest time constant and its neighbours has its maximum, and the
/// relative standard deviation there; nothing at the ends of those tried.
struct LikeliestTau {
  double tau_s = 0.0, relative_sigma = 0.0;
  double slope_of_ln_size = 0.0;  ///< of the likeliest size, over ln(tau)
};

std::optional<LikeliestTau> BetweenTaus(const std::vector<AtTau>& all) {
  const auto best = std::max_element(all.begin(), all.end(), [](const AtTau& a, const AtTau& b) {
    return a.best_log_likelihood < b.best_log_likelihood;
  });
  if (best == all.begin() || best + 1 == all.end()) return std::nullopt;
  const AtTau &before = *(best - 1), &after = *(best + 1);
  const double step = 0.5 * std::log(after.tau_s / before.tau_s);
  const double slope = (after.best_log_likelihood - before.best_log_likelihood) / (2.0 * step);
  const double curvature =
      (2.0 * best->best_log_likelihood - before.best_log_likelihood - after.best_log_likelihood) /
      (step * step);
  if (!(curvature > 0.0)) return std::nullopt;
  const double move = std::clamp(slope / curvature, -step, step);
  const double slope_of_ln_size = std::log(after.size / before.size) / (2.0 * step);
  return LikeliestTau{best->tau_s * std::exp(move), 1.0 / std::sqrt(curvature), slope_of_ln_size};
}

/// A process of the usual size beside what the flight has, at one time constant after another.
class Trial {
 public:
  Trial(const FlightNetwork& solved, int threads, const std::string& effect)
      : solved_(solved), threads_(threads), effect_(effect) {}

  /// Nothing where there is no such network.
  std::optional<AtTau> At(double tau_s) const {
    const EffectSpec& spec = *FindEffect(effect_);
    GapCause process;
    process.effect = effect_;
    process.estimate.resize(static_cast<Eigen::Index>(spec.components.size()));
    for (std::size_t k = 0; k + 1 < spec.components.size(); ++k) {
      process.estimate[static_cast<Eigen::Index>(k)] = spec.components[k].typical;
    }
    process.estimate[process.estimate.size() - 1] = tau_s;
    Flight with = solved_.flight();
    with.config = Adapted(solved_.flight(), {process});
    try {
      return Judge(NetworkBeside(solved_, with, threads_), effect_, tau_s, threads_);
    } catch (const InvalidInput&) {
      return std::nullopt;
    } catch (const RankDeficient&) {
      return std::nullopt;
    }
  }

 private:
  const FlightNetwork& solved_;
  int threads_;
  const std::string& effect_;
};

}  // namespace

void JudgeProcess(const FlightNetwork& solved, int threads, ScreenedEffect* effect) {
  const Trial trial(solved, threads, effect->name);
  std::vector<AtTau> all;
  for (const double tau_s : kProcessTausS) {
    if (const std::optional<AtTau> at = trial.At(tau_s)) all.push_back(*at);
  }
  if (all.empty()) return;
  AtTau best = *std::max_element(all.begin(), all.end(), [](const AtTau& a, const AtTau& b) {
    return a.log_evidence < b.log_evidence;
  });
  LogSum sum;
  for (const AtTau& at : all) sum.Add(at.log_evidence);
  effect->log_evidence = sum.Value() - std::log(static_cast<double>(std::size(kProcessTausS)));
  const std::optional<LikeliestTau> likeliest = BetweenTaus(all);
  if (likeliest) best = trial.At(likeliest->tau_s).value_or(best);
  const double by_tau = likeliest ? likeliest->slope_of_ln_size * likeliest->relative_sigma : 0.0;
  const double relative_sigma = std::hypot(best.relative_sigma, by_tau);
  const EffectSpec& spec = *FindEffect(effect->name);
  const auto last = static_cast<Eigen::Index>(spec.components.size()) - 1;
  for (Eigen::Index k = 0; k < last; ++k) {
    effect->estimate[k] = best.size * spec.components[static_cast<std::size_t>(k)].typical_si();
    effect->sigma[k] = relative_sigma * effect->estimate[k];
  }
  effect->estimate[last] = best.tau_s;
  if (likeliest) effect->sigma[last] = likeliest->relative_sigma * best.tau_s;
}

}  // namespace dn::internal
