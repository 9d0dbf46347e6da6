#include "hypothesis_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn::diagnosis_internal {

HypothesisEvidence MakeEvidence(EffectId id, double log_evidence, const Eigen::VectorXd& estimate,
                                const Eigen::VectorXd& sigma) {
  const double p_value = std::exp(-std::max(0.0, log_evidence));
  return {MakeHypothesis(id), {log_evidence, p_value, estimate, sigma}};
}

void SetProcess(const ProcessEstimate& process, HypothesisEvidence* effect) {
  const EffectSpec& spec = EffectRow(*effect->id);
  const auto last = static_cast<Eigen::Index>(spec.components.size()) - 1;
  effect->estimate.resize(last + 1);
  effect->sigma.resize(last + 1);
  for (Eigen::Index k = 0; k < last; ++k) {
    const double typical = spec.components[static_cast<std::size_t>(k)].typical_si();
    effect->estimate[k] = process.size * typical;
    effect->sigma[k] = process.size_sigma * typical;
  }
  effect->estimate[last] = process.tau_s;
  effect->sigma[last] = process.tau_sigma_s;
}

void SortByEvidence(std::vector<HypothesisEvidence>* effects) {
  std::stable_sort(effects->begin(), effects->end(),
                   [](const auto& a, const auto& b) { return a.log_evidence > b.log_evidence; });
}

bool Contains(const std::vector<HypothesisEvidence>& effects, EffectId id) {
  return std::any_of(effects.begin(), effects.end(),
                     [id](const HypothesisEvidence& effect) { return effect.id == id; });
}

const HypothesisEvidence* FindByName(const std::vector<HypothesisEvidence>& effects,
                                     const std::string& name) {
  for (const HypothesisEvidence& effect : effects) {
    if (effect.name == name) return &effect;
  }
  return nullptr;
}

double FindEvidence(const std::vector<HypothesisEvidence>& effects, const std::string& name) {
  const HypothesisEvidence* effect = FindByName(effects, name);
  return effect == nullptr ? -std::numeric_limits<double>::infinity() : effect->log_evidence;
}

const HypothesisEvidence* BestDiscrepancy(const std::vector<HypothesisEvidence>& effects) {
  const HypothesisEvidence* best = nullptr;
  for (const HypothesisEvidence& effect : effects) {
    if (effect.physical()) continue;
    if (best == nullptr || effect.log_evidence > best->log_evidence) best = &effect;
  }
  return best;
}

double DiscrepancyEvidence(const std::vector<HypothesisEvidence>& effects) {
  const HypothesisEvidence* best = BestDiscrepancy(effects);
  return best == nullptr ? 0.0 : std::max(0.0, best->log_evidence);
}

const HypothesisEvidence* BestPhysical(const std::vector<HypothesisEvidence>& effects) {
  for (const HypothesisEvidence& effect : effects) {
    if (effect.physical()) return &effect;
  }
  return nullptr;
}

GapCause ToCause(const HypothesisEvidence& effect) {
  GapCause cause;
  cause.effect = effect.name;
  static_cast<EffectEvidence&>(cause) = effect;
  cause.times = effect.times;
  cause.absorbed_fraction = effect.absorbed;
  const EffectSpec* spec = FindEffect(effect.name);
  if (spec == nullptr) return cause;
  cause.unit = spec->components[0].unit;
  for (Eigen::Index k = 0; k < cause.estimate.size(); ++k) {
    const double to_si = spec->components[static_cast<std::size_t>(k)].to_si;
    cause.estimate[k] /= to_si;
    cause.sigma[k] /= to_si;
  }
  return cause;
}

GapDiscrepancy ToDiscrepancy(const HypothesisEvidence& effect) {
  return {effect.name, effect.log_evidence, 0.0, effect.period_s, effect.decay_s};
}

std::vector<GapCause> ToCauses(const std::vector<HypothesisEvidence>& effects) {
  std::vector<GapCause> causes;
  causes.reserve(effects.size());
  for (const HypothesisEvidence& effect : effects) causes.push_back(ToCause(effect));
  return causes;
}

}  // namespace dn::diagnosis_internal
