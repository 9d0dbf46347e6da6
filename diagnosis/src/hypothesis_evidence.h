#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/effects/effect_table.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "hypothesis.h"
#include "time_constant.h"

namespace dn::diagnosis_internal {

/// Boresight if a hypothesis is true, and without it.
struct HypothesisBoresight {
  BoresightEstimate with, without;
};

/// A hypothesis with its evidence. Of several hypotheses with one name, it is the one whose window,
/// start and time constant explain the data best. SI. Its p-value is times the number of tests.
struct HypothesisEvidence : Hypothesis, EffectEvidence {
  double statistic = 0.0;  ///< chi-square; 0 for a process
  double absorbed = 0.0;   ///< fraction of the signature that the unknowns absorb
  std::optional<HypothesisBoresight> boresight = {};  ///< absent without a boresight

  bool physical() const { return id.has_value(); }
};

/// Returns the evidence of a noise effect or outliers, with the p-value that follows from it.
HypothesisEvidence MakeEvidence(EffectId id, double log_evidence, const Eigen::VectorXd& estimate,
                                const Eigen::VectorXd& sigma);

/// Sets the estimate of a process to its sizes and its time constant.
void SetProcess(const ProcessEstimate& process, HypothesisEvidence* effect);

/// Sorts effects by evidence, most probable first.
void SortByEvidence(std::vector<HypothesisEvidence>* effects);

/// Returns whether one of the effects is this effect of the table.
bool Contains(const std::vector<HypothesisEvidence>& effects, EffectId id);

/// Returns the effect with this name; null if it is not in the list.
const HypothesisEvidence* FindByName(const std::vector<HypothesisEvidence>& effects,
                                     const std::string& name);
/// Returns the evidence of the effect with this name; minus infinity if it is not in the list.
double FindEvidence(const std::vector<HypothesisEvidence>& effects, const std::string& name);
/// Returns the most probable unmodelled discrepancy; null if there are none.
const HypothesisEvidence* BestDiscrepancy(const std::vector<HypothesisEvidence>& effects);
/// Returns the largest evidence of an unmodelled discrepancy, at least 0.
double DiscrepancyEvidence(const std::vector<HypothesisEvidence>& effects);
/// Returns the most probable effect of the table, from effects sorted by evidence; null if there
/// are none.
const HypothesisEvidence* BestPhysical(const std::vector<HypothesisEvidence>& effects);

/// Converts an effect to the units of the table.
GapCause ToCause(const HypothesisEvidence& effect);
/// Describes an unmodelled discrepancy, with the probability 0.
GapDiscrepancy ToDiscrepancy(const HypothesisEvidence& effect);
/// Converts several effects to the units of the table.
std::vector<GapCause> ToCauses(const std::vector<HypothesisEvidence>& effects);

}  // namespace dn::diagnosis_internal
