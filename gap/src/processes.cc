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
constexpr int kMostTauSteps = 6, kMostStepsAside = 4;
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

/// Half the width of an interval of 95 %, in standard deviations, and how far the logarithm of a
/// likelihood falls to either side of it.
constexpr double kInterval_sigmas = 1.96;
constexpr double kFall_nats = 0.5 * kInterval_sigmas * kInterval_sigmas;

/// A size and a time constant by their logarithms.
struct LogProcess {
  double tau = 0.0, size = 0.0;
};

/// Time constants in equal steps of their logarithm, each tried once.
class TauSteps {
 public:
  TauSteps(const Trial& trial, double tau_s) : trial_(trial), tau_s_(tau_s) {}

  /// In which the likelihood of ln(tau) is a parabola, or nearly.
  static double length() { return std::log(1.6); }

  /// Null where there is no such network.
  const AtTau* At(int step) {
    const auto known = known_.find(step);
    if (known != known_.end()) return known->second ? &*known->second : nullptr;
    const std::optional<AtTau>& at = known_[step] =
        trial_.At(tau_s_ * std::exp(step * length()), [](SizeLikelihood& likelihood) {
          return LikeliestSize(likelihood, {-kSizeStep, 0.0, kSizeStep});
        });
    return at ? &*at : nullptr;
  }

 private:
  const Trial& trial_;
  double tau_s_;
  std::map<int, std::optional<AtTau>> known_;
};

/// Where the likelihood has its maximum between the time constants beside a step.
struct TauPeak {
  int step = 0;
  LogProcess at;
  double log_likelihood = 0.0;
  double relative_sigma = 0.0;  ///< of the size at the time constant
};

std::optional<TauPeak> PeakBeside(TauSteps& steps, int step) {
  const AtTau &before = *steps.At(step - 1), &middle = *steps.At(step),
              &after = *steps.At(step + 1);
  const std::array<double, 3> l{before.best_log_likelihood, middle.best_log_likelihood,
                                after.best_log_likelihood};
  const double length = TauSteps::length();
  const double curvature = (2.0 * l[1] - l[0] - l[2]) / (length * length);
  if (!(curvature > 0.0)) return std::nullopt;
  const double slope = (l[2] - l[0]) / (2.0 * length);
  const double move = std::clamp(slope / curvature, -length, length);
  const double slope_of_size = std::log(after.size / before.size) / (2.0 * length);
  return TauPeak{step,
                 {std::log(middle.tau_s) + move, std::log(middle.size) + slope_of_size * move},
                 l[1] + 0.5 * slope * move,
                 middle.relative_sigma};
}

/// From the peak to the end of its interval, towards longer (1) or shorter (-1) time constants; as
/// far as was tried where the likelihood does not fall so far.
LogProcess Reach(TauSteps& steps, const TauPeak& peak, int direction) {
  LogProcess last = peak.at;
  double last_root = 0.0;  // of the fall
  for (int k = 1; k <= kMostStepsAside; ++k) {
    const AtTau* at = steps.At(peak.step + direction * k);
    if (at == nullptr) break;
    const LogProcess here{std::log(at->tau_s), std::log(at->size)};
    const double root = std::sqrt(std::max(0.0, peak.log_likelihood - at->best_log_likelihood));
    if (root >= std::sqrt(kFall_nats)) {
      const double part = (std::sqrt(kFall_nats) - last_root) / (root - last_root);
      last.tau += part * (here.tau - last.tau);
      last.size += part * (here.size - last.size);
      break;
    }
    last = here;
    last_root = root;
  }
  return {last.tau - peak.at.tau, last.size - peak.at.size};
}

/// The standard deviation, in units of a value, whose interval about it reaches as far up as that of
/// its logarithm, which is the longer side.
double OfLongerSide(double reach) { return std::expm1(std::abs(reach)) / kInterval_sigmas; }

void Take(const TauPeak& peak, const LogProcess& longer, const LogProcess& shorter,
          ScreenedEffect* effect) {
  const double with_tau = std::max(std::abs(longer.size), std::abs(shorter.size));
  const double reach = std::hypot(kInterval_sigmas * peak.relative_sigma, with_tau);
  AtTau at;
  at.tau_s = std::exp(peak.at.tau);
  at.size = std::exp(peak.at.size);
  at.relative_sigma = OfLongerSide(reach);
  Take(at, effect);
  effect->sigma[effect->sigma.size() - 1] =
      at.tau_s * std::max(OfLongerSide(longer.tau), -std::expm1(shorter.tau) / kInterval_sigmas);
}

/// The step beside which the likelihood falls to both sides; nothing where there is none near.
std::optional<int> LikeliestStep(TauSteps& steps, int* last) {
  for (int pass = 0; pass < kMostTauSteps; ++pass) {
    const AtTau *before = steps.At(*last - 1), *at = steps.At(*last), *after = steps.At(*last + 1);
    if (before == nullptr || at == nullptr || after == nullptr) return std::nullopt;
    const double l = at->best_log_likelihood;
    if (before->best_log_likelihood > l &&
        before->best_log_likelihood >= after->best_log_likelihood) {
      --*last;
    } else if (after->best_log_likelihood > l) {
      ++*last;
    } else {
      return *last;
    }
  }
  return std::nullopt;
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
  TauSteps steps(trial, effect->estimate[effect->estimate.size() - 1]);
  int last = 0;
  const std::optional<int> likeliest = LikeliestStep(steps, &last);
  const std::optional<TauPeak> peak = likeliest ? PeakBeside(steps, *likeliest) : std::nullopt;
  if (peak) {
    Take(*peak, Reach(steps, *peak, 1), Reach(steps, *peak, -1), effect);
    return;
  }
  if (steps.At(0) == nullptr || steps.At(last) == nullptr) return;
  // The flight is too short, or the node rate too low, for the end of the correlation to show: the
  // size goes with the time constant, which may be anything from where it began on.
  AtTau open = *steps.At(last);
  open.relative_sigma = std::hypot(open.relative_sigma, std::log(open.size / steps.At(0)->size));
  Take(open, effect);
}

}  // namespace dn::internal
