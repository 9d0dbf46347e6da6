#include "time_constant.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace dn::diagnosis_internal {
namespace {

constexpr int kMostTauSteps = 6, kMaxIntervalSteps = 4;
// Half width of a 95 % interval in sigmas, and the decrease of the log likelihood at its ends.
constexpr double kInterval_sigmas = 1.96;
constexpr double kFall_nats = 0.5 * kInterval_sigmas * kInterval_sigmas;

/// Time constants in equal steps of their logarithm, each evaluated once.
class TauSteps {
 public:
  TauSteps(const SizesByTau& sizes, double tau_s) : sizes_(sizes), log_tau_(std::log(tau_s)) {}

  /// Returns the step of ln(tau), over which the log likelihood is nearly a parabola.
  static double length() { return std::log(1.6); }

  double LogTau(int step) const { return log_tau_ + step * length(); }

  /// Returns null if the network cannot be built.
  const LikelySize* At(int step) {
    auto known = known_.find(step);
    if (known == known_.end()) {
      known = known_.emplace(step, sizes_(std::exp(LogTau(step)))).first;
    }
    return known->second ? &*known->second : nullptr;
  }

 private:
  const SizesByTau& sizes_;
  double log_tau_;
  std::map<int, std::optional<LikelySize>> known_;
};

/// Logarithms of a size and a time constant.
struct LogProcess {
  double tau = 0.0, size = 0.0;
};

/// Maximum of the likelihood between the neighbouring time constants of a step.
struct TauPeak {
  int step = 0;
  LogProcess at;
  double log_likelihood = 0.0;
  double relative_sigma = 0.0;  ///< of the size at the time constant
};

/// Search for the step at which the likelihood decreases on both sides.
struct Search {
  int last = 0;
  bool complete = true;  ///< all networks could be built
  bool found = false;
};

Search FindLikeliestStep(TauSteps& steps) {
  Search search;
  for (int pass = 0; pass < kMostTauSteps && !search.found; ++pass) {
    const LikelySize *before = steps.At(search.last - 1), *at = steps.At(search.last),
                     *after = steps.At(search.last + 1);
    if (before == nullptr || at == nullptr || after == nullptr) {
      search.complete = false;
      return search;
    }
    const double l = at->log_likelihood;
    if (before->log_likelihood > l && before->log_likelihood >= after->log_likelihood) {
      --search.last;
    } else if (after->log_likelihood > l) {
      ++search.last;
    } else {
      search.found = true;
    }
  }
  return search;
}

std::optional<TauPeak> PeakBetweenNeighbours(TauSteps& steps, int step) {
  const LikelySize &before = *steps.At(step - 1), &middle = *steps.At(step),
                   &after = *steps.At(step + 1);
  const double length = TauSteps::length();
  const double curvature =
      (2.0 * middle.log_likelihood - before.log_likelihood - after.log_likelihood) /
      (length * length);
  if (!(curvature > 0.0)) return std::nullopt;
  const double slope = (after.log_likelihood - before.log_likelihood) / (2.0 * length);
  const double move = std::clamp(slope / curvature, -length, length);
  const double slope_of_size = std::log(after.size / before.size) / (2.0 * length);
  return TauPeak{step,
                 {steps.LogTau(step) + move, std::log(middle.size) + slope_of_size * move},
                 middle.log_likelihood + 0.5 * slope * move,
                 middle.relative_sigma};
}

/// Returns the distance from the peak to the end of its interval, towards longer (1) or shorter
/// (-1) time constants.
LogProcess Reach(TauSteps& steps, const TauPeak& peak, int direction) {
  LogProcess end = peak.at;
  double end_root = 0.0;  // root of the decrease, linear in ln(tau) for a normal likelihood
  for (int k = 1; k <= kMaxIntervalSteps; ++k) {
    const int step = peak.step + direction * k;
    const LikelySize* at = steps.At(step);
    if (at == nullptr) break;
    const LogProcess here{steps.LogTau(step), std::log(at->size)};
    const double root = std::sqrt(std::max(0.0, peak.log_likelihood - at->log_likelihood));
    const bool beyond = root >= std::sqrt(kFall_nats);
    const double part = beyond ? (std::sqrt(kFall_nats) - end_root) / (root - end_root) : 1.0;
    end.tau += part * (here.tau - end.tau);
    end.size += part * (here.size - end.size);
    if (beyond) break;
    end_root = root;
  }
  return {end.tau - peak.at.tau, end.size - peak.at.size};
}

/// Returns the relative sigma of a value from the interval of its logarithm, which reaches further
/// upwards.
double RelativeSigma(double reach) { return std::expm1(std::abs(reach)) / kInterval_sigmas; }

ProcessEstimate Estimate(TauSteps& steps, const TauPeak& peak) {
  const LogProcess longer = Reach(steps, peak, 1), shorter = Reach(steps, peak, -1);
  const double with_tau = std::max(std::abs(longer.size), std::abs(shorter.size));
  const double reach = std::hypot(kInterval_sigmas * peak.relative_sigma, with_tau);
  ProcessEstimate estimate;
  estimate.size = std::exp(peak.at.size);
  estimate.size_sigma = estimate.size * RelativeSigma(reach);
  estimate.tau_s = std::exp(peak.at.tau);
  estimate.tau_sigma_s = estimate.tau_s * std::max(RelativeSigma(longer.tau),
                                                   -std::expm1(shorter.tau) / kInterval_sigmas);
  return estimate;
}

/// Returns the estimate of a search without a maximum. The flight is then too short, or the node
/// rate too low, to show the end of the correlation. The sigma of the size includes its change
/// since the start of the search.
ProcessEstimate OpenEstimate(TauSteps& steps, int last) {
  const LikelySize &start = *steps.At(0), &open = *steps.At(last);
  ProcessEstimate estimate;
  estimate.size = open.size;
  estimate.size_sigma =
      open.size * std::hypot(open.relative_sigma, std::log(open.size / start.size));
  estimate.tau_s = std::exp(steps.LogTau(last));
  estimate.tau_sigma_s = std::numeric_limits<double>::quiet_NaN();
  return estimate;
}

}  // namespace

std::optional<ProcessEstimate> LikeliestProcess(const SizesByTau& sizes, double tau_s) {
  TauSteps steps(sizes, tau_s);
  const Search search = FindLikeliestStep(steps);
  if (!search.complete) return std::nullopt;
  const std::optional<TauPeak> peak =
      search.found ? PeakBetweenNeighbours(steps, search.last) : std::nullopt;
  return peak ? Estimate(steps, *peak) : OpenEstimate(steps, search.last);
}

}  // namespace dn::diagnosis_internal
