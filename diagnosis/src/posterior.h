#pragma once

#include <vector>

#include "hypothesis_evidence.h"

namespace dn::diagnosis_internal {

/// Assumptions about what may have happened to a flight, before its data are seen.
struct HypothesisPrior {
  /// Probability that what happened is not in the library, if something did.
  double outside = 0.0;
  /// Largest evidence that noise alone gives to a rest. Smaller rests stay unseen.
  double unseen_nats = 1.0;
  /// Evidence of a significant rest that all these hypotheses leave, nats; 0 without a rest.
  double rest_nats = 0.0;
};

/// Posterior probabilities of hypotheses. At most one of them is true.
struct HypothesisPosterior {
  double nothing = 1.0;
  /// Probability of each hypothesis: an effect of the table, or something outside the library that
  /// looks like this discrepancy.
  std::vector<double> own;
  /// Probability of something outside the library that looks like this effect; 0 for discrepancies.
  std::vector<double> resembling;
  /// Probability that something outside the library is present, alone or with an effect.
  double outside = 0.0;
};

/// Returns the share of the signature of something outside the library that differs from the effect
/// which it resembles. The effect has this evidence, and the rest is unseen or has `rest_nats`.
double DifferingShare(const HypothesisPrior& prior, double log_evidence);

/// Returns the probabilities of hypotheses with evidence B. With P = `outside`, n_e effects of
/// the table, n hypotheses altogether, and the share u of DifferingShare, the weights are
///
///   nothing                            1/2
///   effect k                           1/2 (1 - P) / n_e B_k   times P with a significant rest
///   outside, looks like discrepancy d  1/2 P / n B_d
///   outside, looks like effect k       1/2 P / n B_k           times u without one
///
/// The first factor is that of a second event, outside the library, that explains the rest. The
/// evidence of a discrepancy that fits no better than a simpler effect is at most that of the
/// effect. docs/method/gap-method.md gives the reasons.
HypothesisPosterior ComputePosterior(const std::vector<HypothesisEvidence>& hypotheses,
                                     const HypothesisPrior& prior);

}  // namespace dn::diagnosis_internal
