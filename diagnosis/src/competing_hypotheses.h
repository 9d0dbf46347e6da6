#pragma once

#include <dn/diagnosis/diagnosis.h>

#include <string>
#include <vector>

#include "hypothesis_evidence.h"
#include "posterior.h"

namespace dn::diagnosis_internal {

/// A cause of the verdict and its competing hypotheses, given all other causes.
struct CompetingHypotheses {
  std::string effect;  ///< empty: there is no cause
  /// Effects of the screen without the cause; the cause is one of them.
  std::vector<HypothesisEvidence> competing_effects;
  HypothesisPosterior posterior;          ///< of the competing effects, in their order
  std::vector<double> differing;          ///< DifferingShare of each competing effect
  std::vector<std::string> credible_set;  ///< 95 %, effects of the table
  double discrepancy_posterior = 0.0;     ///< total of the unmodelled discrepancies
};

/// Makes the competing hypotheses of a cause, which is one of `competing_effects`.
CompetingHypotheses MakeCompetingHypotheses(
    const std::string& effect, const std::vector<HypothesisEvidence>& competing_effects,
    const HypothesisPrior& prior);

/// Adds the causes and discrepancies to a diagnosis: every effect of a screen. The causes `named`
/// come first, with the evidence and the alternatives of their own set. Sets all probabilities.
void FillCauses(const std::vector<HypothesisEvidence>& screened,
                const std::vector<CompetingHypotheses>& sets, const std::vector<GapCause>& named,
                GapDiagnosis* diagnosis);

/// Sets the probabilities of causes, discrepancies and physics outside the library. They are over
/// all sets of competing hypotheses, or for a named cause in its own set.
void SetProbabilities(const std::vector<CompetingHypotheses>& sets, GapDiagnosis* diagnosis);

/// Facts that decide the kind of a verdict.
struct Decision {
  bool detected = false;
  bool discrepancy_is_better = false;  ///< than the named effects
  bool gap_remains = false;            ///< a part of the gap that the named effects do not explain
};

/// Returns the verdict on the named effects, given their competing hypotheses. Names no effect if
/// an unmodelled discrepancy is more probable than all names together and fits the data as well as
/// they do.
GapVerdict Decide(const Decision& decision, const std::vector<std::string>& named,
                  const std::vector<CompetingHypotheses>& sets);

}  // namespace dn::diagnosis_internal
