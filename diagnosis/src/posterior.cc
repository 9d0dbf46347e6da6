#include "posterior.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn::diagnosis_internal {
namespace {

constexpr double kPriorNothing = 0.5;

/// Returns the evidence of a discrepancy, limited by that of simpler effects with an equal fit. Its
/// lead over such an effect is due to the typical sizes alone.
double LimitedEvidence(const HypothesisEvidence& discrepancy,
                       const std::vector<HypothesisEvidence>& hypotheses) {
  double most = -std::numeric_limits<double>::infinity();
  bool limited = false;
  for (const HypothesisEvidence& effect : hypotheses) {
    if (!effect.physical() || !(effect.statistic > 0.0)) continue;
    if (effect.statistic < discrepancy.statistic) continue;
    if (effect.typical.size() > discrepancy.typical.size()) continue;
    most = std::max(most, effect.log_evidence);
    limited = true;
  }
  return limited ? std::min(most, discrepancy.log_evidence) : discrepancy.log_evidence;
}

/// The logs of the weights of a hypothesis and of what resembles it.
struct LogWeights {
  double own, resembling;
};

}  // namespace

double DifferingShare(const HypothesisPrior& prior, double log_evidence) {
  const double rest = std::max(prior.unseen_nats, prior.rest_nats);
  return rest / (rest + std::max(0.0, log_evidence));
}

HypothesisPosterior ComputePosterior(const std::vector<HypothesisEvidence>& hypotheses,
                                     const HypothesisPrior& prior) {
  const auto n = static_cast<double>(hypotheses.size());
  const auto effects = static_cast<double>(std::count_if(
      hypotheses.begin(), hypotheses.end(), [](const auto& one) { return one.physical(); }));
  const bool rest = prior.rest_nats > 0.0;
  const double something = 1.0 - kPriorNothing;
  const double inside = something * (1.0 - prior.outside) * (rest ? prior.outside : 1.0);
  const double log_inside = std::log(inside / std::max(1.0, effects));
  const double log_outside = std::log(something * prior.outside / std::max(1.0, n));
  std::vector<LogWeights> logs;
  double largest = std::log(kPriorNothing);
  for (const HypothesisEvidence& one : hypotheses) {
    LogWeights log{log_outside, -std::numeric_limits<double>::infinity()};
    if (one.physical()) {
      const double unseen = rest ? 1.0 : DifferingShare(prior, one.log_evidence);
      log = {log_inside + one.log_evidence, log_outside + std::log(unseen) + one.log_evidence};
    } else {
      log.own += LimitedEvidence(one, hypotheses);
    }
    largest = std::max({largest, log.own, log.resembling});
    logs.push_back(log);
  }
  HypothesisPosterior out;
  out.nothing = kPriorNothing * std::exp(-largest);
  double sum = out.nothing;
  for (const LogWeights& log : logs) {
    out.own.push_back(std::exp(log.own - largest));
    out.resembling.push_back(std::exp(log.resembling - largest));
    sum += out.own.back() + out.resembling.back();
  }
  out.nothing /= sum;
  for (std::size_t k = 0; k < hypotheses.size(); ++k) {
    out.own[k] /= sum;
    out.resembling[k] /= sum;
    out.outside += out.resembling[k];
    if (rest || !hypotheses[k].physical()) out.outside += out.own[k];
  }
  return out;
}

}  // namespace dn::diagnosis_internal
