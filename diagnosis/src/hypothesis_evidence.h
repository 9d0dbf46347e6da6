#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/effects/effect_table.h>
#include <dn/files/effect_times.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace dn::internal {

/// Evidence for one effect or unmodelled discrepancy, with the window, start and time constant that
/// explain the data best. SI.
struct HypothesisEvidence {
  std::string name;
  std::optional<EffectId> id;  ///< nullopt for an unmodelled discrepancy
  EffectTimes times;
  std::optional<double> period_s;
  std::optional<double> decay_s;
  double log_evidence = 0.0;  ///< averaged over sizes, windows and time constants
  double p_value = 1.0;       ///< of the best candidate, times the number of candidates
  double statistic = 0.0;     ///< chi-square of the best candidate; 0 for a process
  Eigen::VectorXd estimate;   ///< for a process: sigmas, then tau
  Eigen::VectorXd sigma;      ///< NaN for a tau
  double absorbed = 0.0;      ///< fraction of the signature that the unknowns absorb
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  std::size_t candidate = 0;  ///< index in the library

  bool physical() const { return id.has_value(); }
};

using ScreenedEffect = HypothesisEvidence;

/// Returns an effect of the table without any evidence.
HypothesisEvidence MakeUnscreened(EffectId id);

/// Sorts effects by evidence, most probable first.
void SortByEvidence(std::vector<HypothesisEvidence>* effects);

/// Returns whether one of the effects is this effect of the table.
bool Contains(const std::vector<HypothesisEvidence>& effects, EffectId id);

/// Converts an effect to the units of the table.
GapCause ToCause(const HypothesisEvidence& effect);
/// Converts several effects to the units of the table.
std::vector<GapCause> ToCauses(const std::vector<HypothesisEvidence>& effects);

}  // namespace dn::internal
