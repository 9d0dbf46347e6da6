#include "processes.h"

#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/gap/adapt.h>
#include <dn/log_sum.h>
#include <dn/solvers/restricted_likelihood.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "likelihood_peak.h"
#include "network_beside.h"

namespace dn::internal {
namespace {

constexpr double kProcessTausS[] = {4.0, 15.0, 60.0, 240.0};
// How likely the sizes are that are a tenth of the usual one, to ten times that, by equal factors.
constexpr double kWeights[] = {0.1, 0.2, 0.4, 0.2, 0.1};
constexpr double kMostLogSize = 3.5;
constexpr int kMostTauSteps = 6;
// Of the logarithm of sizes that are tried first about one that is nearly known.
constexpr double kSizeStep = 0.2;
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

/// Where the parabola through three values, `step` apart, has its maximum: from the middle one; and
/// the standard deviation of a normal likelihood there.
struct Vertex {
  double move = 0.0, sigma = 0.0;
};

std::optional<Vertex> VertexOf(const std::array<double, 3>& l, double step) {
  const double slope = (l[2] - l[0]) / (2.0 * step);
  const double curvature = (2.0 * l[1] - l[0] - l[2]) / (step * step);
  if (!(curvature > 0.0)) return std::nullopt;
  return Vertex{std::clamp(slope / curvature, -step, step), 1.0 / std::sqrt(curvature)};
}

/// Log likelihoods of the size of a process by its logarithm, in usual sizes, against a process that
/// is as good as absent.
class SizeLikelihood {
 public:
  SizeLikelihood(const FlightNetwork& network, const std::string& effect, int threads)
      : linearized_(network.net),
        likelihood_(linearized_, RowsOfChain(network, linearized_, NewestChain(network, effect)),
                    threads) {}

  std::vector<double> operator()(const std::vector<double>& log_sizes) {
    std::vector<double> thetas{kAbsent * kAbsent - 1.0};
    for (const double log_size : log_sizes) thetas.push_back(std::expm1(2.0 * log_size));
    const std::vector<double> all = likelihood_.At(thetas);
    std::vector<double> l;
    for (std::size_t k = 1; k < all.size(); ++k) l.push_back(all[k] - all[0]);
    return l;
  }

 private:
  LinearizedNetwork linearized_;
  VarianceLikelihood likelihood_;
};

/// The likeliest size; `first`: logarithms to begin with.
AtTau LikeliestSize(SizeLikelihood& likelihood, const std::vector<double>& first) {
  const auto values = [&](const std::vector<double>& log_sizes) { return likelihood(log_sizes); };
  AtTau at;
  if (const auto peak = FindPeak(values, first, -kMostLogSize, kMostLogSize)) {
    at.size = std::exp(peak->log_size);
    at.relative_sigma = peak->width;
    at.best_log_likelihood = peak->value;
    return at;
  }
  const std::vector<double> l = likelihood(first);
  const auto best = static_cast<std::size_t>(std::max_element(l.begin(), l.end()) - l.begin());
  at.size = std::exp(first[best]);
  at.best_log_likelihood = l[best];
  return at;
}

AtTau Judge(SizeLikelihood& likelihood) {
  const double step = 0.5 * std::log(10.0);
  const std::vector<double> log_sizes{-2.0 * step, -step, 0.0, step, 2.0 * step};
  AtTau at = LikeliestSize(likelihood, log_sizes);
  const std::vector<double> l = likelihood(log_sizes);
  double sum = 0.0;
  for (std::size_t g = 0; g < l.size(); ++g) {
    sum += kWeights[g] * std::exp(l[g] - at.best_log_likelihood);
  }
  // Between the five sizes the likelihood may have its peak: they are taken as wide as their steps.
  const double peak = std::min(1.0, at.relative_sigma / step) * 0.2;
  at.log_evidence = at.best_log_likelihood + std::log(std::max({sum, peak, 1e-300}));
  return at;
}

/// A process of the usual size beside what the flight has, at one time constant after another.
class Trial {
 public:
  /// `scale`: of the size that the states are laid out for, in usual ones.
  Trial(const FlightNetwork& solved, int threads, const std::string& effect, double scale)
      : solved_(solved), threads_(threads), effect_(effect), scale_(scale) {}

  /// What `judge` makes of the likelihood of the size at a time constant; nothing where there is no
  /// such network.
  template <class Judge>
  std::optional<AtTau> At(double tau_s, const Judge& judge) const {
    const EffectSpec& spec = *FindEffect(effect_);
    GapCause process;
    process.effect = effect_;
    process.estimate.resize(static_cast<Eigen::Index>(spec.components.size()));
    for (std::size_t k = 0; k + 1 < spec.components.size(); ++k) {
      process.estimate[static_cast<Eigen::Index>(k)] = scale_ * spec.components[k].typical;
    }
    process.estimate[process.estimate.size() - 1] = tau_s;
    Flight with = solved_.flight();
    with.config = Adapted(solved_.flight(), {process});
    try {
      SizeLikelihood likelihood(NetworkBeside(solved_, with, threads_), effect_, threads_);
      AtTau at = judge(likelihood);
      at.tau_s = tau_s;
      at.size *= scale_;
      return at;
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
  double scale_;
};

/// Size and time constant as those of an effect.
void Take(const AtTau& at, ScreenedEffect* effect) {
  const EffectSpec& spec = *FindEffect(effect->name);
  const auto last = static_cast<Eigen::Index>(spec.components.size()) - 1;
  for (Eigen::Index k = 0; k < last; ++k) {
    effect->estimate[k] = at.size * spec.components[static_cast<std::size_t>(k)].typical_si();
    effect->sigma[k] = at.relative_sigma * effect->estimate[k];
  }
  effect->estimate[last] = at.tau_s;
  effect->sigma[last] = std::numeric_limits<double>::quiet_NaN();
}

/// At the likeliest of three time constants, equally spaced in their logarithm; the size changes
/// with that, which makes it less certain.
AtTau Between(const AtTau& before, const AtTau& at, const AtTau& after, const Vertex& vertex) {
  const double step = 0.5 * std::log(after.tau_s / before.tau_s);
  const double slope_of_ln_size = std::log(after.size / before.size) / (2.0 * step);
  AtTau between = at;
  between.tau_s = at.tau_s * std::exp(vertex.move);
  between.size = at.size * std::exp(slope_of_ln_size * vertex.move);
  between.relative_sigma = std::hypot(at.relative_sigma, slope_of_ln_size * vertex.sigma);
  return between;
}

}  // namespace

void JudgeProcess(const FlightNetwork& solved, int threads, ScreenedEffect* effect) {
  const Trial trial(solved, threads, effect->name, 1.0);
  std::vector<AtTau> all;
  for (const double tau_s : kProcessTausS) {
    if (const std::optional<AtTau> at = trial.At(tau_s, &Judge)) all.push_back(*at);
  }
  if (all.empty()) return;
  LogSum sum;
  for (const AtTau& at : all) sum.Add(at.log_evidence);
  effect->log_evidence = sum.Value() - std::log(static_cast<double>(std::size(kProcessTausS)));
  Take(*std::max_element(
           all.begin(), all.end(),
           [](const AtTau& a, const AtTau& b) { return a.log_evidence < b.log_evidence; }),
       effect);
}

void RefineProcess(const FlightNetwork& solved, int threads, ScreenedEffect* effect) {
  const double scale = effect->estimate[0] / FindEffect(effect->name)->components[0].typical_si();
  const Trial trial(solved, threads, effect->name, scale);
  const Eigen::Index last = effect->estimate.size() - 1;
  // A step in which the likelihood of ln(tau) is a parabola, or nearly.
  const double step = std::log(1.6);
  double tau_s = effect->estimate[last];
  std::map<int, AtTau> at;  // by steps from where it began
  int middle = 0;
  for (int pass = 0; pass < kMostTauSteps; ++pass) {
    for (int k = middle - 1; k <= middle + 1; ++k) {
      if (at.count(k) > 0) continue;
      const std::optional<AtTau> one =
          trial.At(tau_s * std::exp(k * step), [](SizeLikelihood& likelihood) {
            return LikeliestSize(likelihood, {-kSizeStep, 0.0, kSizeStep});
          });
      if (!one) return;
      at[k] = *one;
    }
    const auto l = [&](int k) { return at[middle + k].best_log_likelihood; };
    if (l(-1) > l(0) && l(-1) >= l(1)) {
      --middle;
    } else if (l(1) > l(0)) {
      ++middle;
    } else {
      const std::optional<Vertex> vertex = VertexOf({l(-1), l(0), l(1)}, step);
      if (!vertex) return;
      Take(Between(at[middle - 1], at[middle], at[middle + 1], *vertex), effect);
      effect->sigma[last] = vertex->sigma * effect->estimate[last];
      return;
    }
  }
  // The flight is too short, or the node rate too low, for the end of the correlation to show: the
  // size goes with the time constant, which may be anything from where it began on.
  AtTau open = at[middle];
  open.relative_sigma = std::hypot(open.relative_sigma, std::log(open.size / at[0].size));
  Take(open, effect);
}

}  // namespace dn::internal
