#include "processes.h"

#include <dn/diagnosis/adapt.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/log_sum.h>
#include <dn/size_prior.h>
#include <dn/solvers/restricted_likelihood.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <type_traits>
#include <utility>

#include "changed_network.h"
#include "likelihood_peak.h"
#include "time_constant.h"

namespace dn::diagnosis_internal {
namespace {

constexpr double kProcessTausS[] = {4.0, 15.0, 60.0, 240.0};
constexpr double kMostLogSize = 3.5;
// Step between the logarithms of the sizes that are tried first around a nearly known size.
constexpr double kSizeStep = 0.2;
// Fraction of the typical sigma at which a process is practically absent.
constexpr double kAbsent = 1e-3;

const ProcessChain& NewestChain(const FlightNetwork& network, EffectId effect) {
  if (effect == EffectId::kGyroBiasProcess) return network.trajectory().gyro_bias().back();
  if (effect == EffectId::kAccelBiasProcess) return network.trajectory().accel_bias().back();
  return network.trajectory().gnss_error().back();
}

/// Returns 1 for the rows that state the size of a process, and 0 for all other rows. These are the
/// prior and the steps of a chain.
Eigen::VectorXd ChainRows(const FlightNetwork& network, const LinearizedNetwork& linearized,
                          const ProcessChain& chain) {
  std::set<BlockId> blocks;
  for (const auto& block : chain.blocks) blocks.insert(block.id);
  Eigen::VectorXd share = Eigen::VectorXd::Zero(linearized.rows());
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    const FactorGroup::Kind kind = linearized.group(rows.factor).kind;
    if (kind == FactorGroup::Kind::kMeasurement) continue;
    const std::vector<BlockId>& of = network.net().factor(rows.factor).blocks;
    const bool inside =
        std::all_of(of.begin(), of.end(), [&](BlockId id) { return blocks.count(id) > 0; });
    if (inside) share.segment(rows.first, rows.count).setOnes();
  }
  return share;
}

/// A process with one time constant, evaluated over all its sizes.
struct JudgedProcess {
  double tau_s = 0.0;
  LikelySize likeliest;
  double log_evidence = 0.0;
};

/// Log likelihood of the size of a process, relative to a process that is practically absent. The
/// argument is the logarithm of the size, as a multiple of the size that the network states.
class SizeLikelihood {
 public:
  SizeLikelihood(const FlightNetwork& network, EffectId effect, int threads)
      : linearized_(network.net()),
        likelihood_(linearized_, ChainRows(network, linearized_, NewestChain(network, effect)),
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

/// Returns the most probable size. `first` are the logarithms to start with.
LikelySize LikeliestSize(SizeLikelihood& likelihood, const std::vector<double>& first) {
  const auto values = [&](const std::vector<double>& log_sizes) { return likelihood(log_sizes); };
  if (const auto peak = FindPeak(values, first, -kMostLogSize, kMostLogSize)) {
    return {std::exp(peak->log_size), peak->width, peak->value};
  }
  const std::vector<double> l = likelihood(first);
  const auto best = static_cast<std::size_t>(std::max_element(l.begin(), l.end()) - l.begin());
  LikelySize at;
  at.size = std::exp(first[best]);
  at.log_likelihood = l[best];
  return at;
}

JudgedProcess Judge(SizeLikelihood& likelihood) {
  constexpr double kStep = 0.5 * std::numbers::ln10;  // between the logarithms of two sizes
  std::vector<double> log_sizes;
  for (const double size : SizePrior::kTimesTypical) log_sizes.push_back(std::log(size));
  const LikelySize at = LikeliestSize(likelihood, log_sizes);
  const std::vector<double> l = likelihood(log_sizes);
  double sum = 0.0;
  for (std::size_t g = 0; g < l.size(); ++g) {
    sum += SizePrior::kProbability[g] * std::exp(l[g] - at.log_likelihood);
  }
  // The likelihood may peak between the five sizes, so each of them represents the width of a step.
  const double peak = std::min(1.0, at.relative_sigma / kStep) * 0.2;
  return {0.0, at, at.log_likelihood + std::log(std::max({sum, peak, 1e-300}))};
}

/// Networks of a flight with one additional process, one network per time constant.
class Trial {
 public:
  /// `scale`: size of the process that the network states, as a multiple of its typical size.
  Trial(const FlightNetwork& solved, int threads, EffectId effect, double scale)
      : solved_(solved), threads_(threads), effect_(effect), scale_(scale) {}

  /// Returns the result of `judge` for the likelihood of the size, in units of `scale`, at one time
  /// constant. Returns nullopt if the network cannot be built.
  template <class Judge>
  auto At(double tau_s, const Judge& judge) const
      -> std::optional<std::invoke_result_t<Judge, SizeLikelihood&>> {
    const EffectSpec& spec = EffectRow(effect_);
    GapCause process;
    process.effect = spec.name;
    process.estimate.resize(static_cast<Eigen::Index>(spec.components.size()));
    for (std::size_t k = 0; k + 1 < spec.components.size(); ++k) {
      process.estimate[static_cast<Eigen::Index>(k)] = scale_ * spec.components[k].typical;
    }
    process.estimate[process.estimate.size() - 1] = tau_s;
    Flight with = solved_.flight();
    with.config = Adapted(solved_.flight(), {process});
    try {
      SizeLikelihood likelihood(BuildChangedNetwork(solved_, with, threads_), effect_, threads_);
      return judge(likelihood);
    } catch (const InvalidInput&) {
      return std::nullopt;
    } catch (const RankDeficient&) {
      return std::nullopt;
    }
  }

 private:
  const FlightNetwork& solved_;
  int threads_;
  EffectId effect_;
  double scale_;
};

}  // namespace

void EvaluateProcess(const FlightNetwork& solved, int threads, HypothesisEvidence* effect) {
  const Trial trial(solved, threads, *effect->id, 1.0);
  std::vector<JudgedProcess> all;
  for (const double tau_s : kProcessTausS) {
    std::optional<JudgedProcess> at = trial.At(tau_s, &Judge);
    if (!at) continue;
    at->tau_s = tau_s;
    all.push_back(*at);
  }
  if (all.empty()) return;
  LogSum sum;
  for (const JudgedProcess& at : all) sum.Add(at.log_evidence);
  effect->log_evidence = sum.Value() - std::log(static_cast<double>(std::size(kProcessTausS)));
  const JudgedProcess& best =
      *std::max_element(all.begin(), all.end(), [](const JudgedProcess& a, const JudgedProcess& b) {
        return a.log_evidence < b.log_evidence;
      });
  const LikelySize& size = best.likeliest;
  SetProcess({size.size, size.size * size.relative_sigma, best.tau_s,
              std::numeric_limits<double>::quiet_NaN()},
             effect);
}

void RefineProcess(const FlightNetwork& solved, int threads, HypothesisEvidence* effect) {
  const EffectSpec& spec = EffectRow(*effect->id);
  const Eigen::Index last = effect->estimate.size() - 1;
  const double scale = effect->estimate[0] / spec.components[0].typical_si();
  const Trial trial(solved, threads, *effect->id, scale);
  const auto sizes = [&](double tau_s) {
    return trial.At(tau_s, [scale](SizeLikelihood& likelihood) {
      LikelySize at = LikeliestSize(likelihood, {-kSizeStep, 0.0, kSizeStep});
      at.size *= scale;
      return at;
    });
  };
  const std::optional<ProcessEstimate> likeliest = LikeliestProcess(sizes, effect->estimate[last]);
  if (likeliest) SetProcess(*likeliest, effect);
}

}  // namespace dn::diagnosis_internal
