#include "forward_selection.h"

#include <dn/effects/effect_table.h>
#include <dn/interrupted.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "decision.h"

namespace dn::diagnosis_internal {
ForwardSelection::ForwardSelection(SelectionPolicy policy, Refit refit,
                                   std::unique_ptr<ExtendedFit> base)
    : policy_(std::move(policy)), refit_(std::move(refit)) {
  out_.base = std::move(base);
}

void ForwardSelection::Grow() {
  while (out_.chosen.size() < policy_.most) {
    const HypothesisEvidence* best = Next(out_.last().effects);
    if (best == nullptr || best->log_evidence < policy_.threshold_nats) break;
    ShowProgress("with " + best->name,
                 static_cast<double>(out_.chosen.size()) / static_cast<double>(policy_.most));
    out_.explained_nats += best->log_evidence;
    out_.chosen.push_back(Refined(out_.last(), *best));
    if (!policy_.refits) break;
    std::unique_ptr<ExtendedFit> next = TryFit(out_.chosen);
    if (!next) break;
    if (out_.final) before_.push_back(std::move(out_.final));
    out_.final = std::move(next);
    if (policy_.resizes_noise) ReconsiderNoise();
  }
}

void ForwardSelection::Revise() {
  for (std::size_t k = 0; k + 1 < out_.chosen.size(); ++k) {
    const std::string& name = out_.chosen[k].name;
    ShowProgress("without " + name, 1.0);
    const ExtendedFit* others = FitWithout(k);
    const HypothesisEvidence* best = others ? Next(others->effects) : nullptr;
    if (best == nullptr) continue;
    if (best->log_evidence < policy_.threshold_nats) {
      Replace(Without(k));
      return;
    }
    const HypothesisEvidence* own = FindByName(others->effects, name);
    if (own != nullptr && best->log_evidence < own->log_evidence + kReplacementLeadNats) {
      confirmed_[k] = others->effects;
      continue;
    }
    std::vector<HypothesisEvidence> chosen = Without(k);
    chosen.push_back(Refined(*others, *best));
    Replace(chosen);
    return;
  }
}

std::vector<std::vector<HypothesisEvidence>> ForwardSelection::Alternatives() {
  std::vector<std::vector<HypothesisEvidence>> alternatives;
  for (std::size_t k = 0; k < out_.chosen.size(); ++k) {
    const auto confirmed = confirmed_.find(k);
    if (confirmed != confirmed_.end()) {
      alternatives.push_back(confirmed->second);
      continue;
    }
    const ExtendedFit* others = FitWithout(k);
    alternatives.push_back((others ? *others : *out_.base).effects);
  }
  return alternatives;
}

const HypothesisEvidence* ForwardSelection::Next(
    const std::vector<HypothesisEvidence>& effects) const {
  return policy_.next(effects);
}

HypothesisEvidence ForwardSelection::Refined(const ExtendedFit& fit,
                                             const HypothesisEvidence& effect) const {
  return policy_.refine ? policy_.refine(fit, effect) : effect;
}

void ForwardSelection::ShowProgress(const std::string& stage, double fraction) const {
  if (policy_.progress) policy_.progress(stage, fraction);
}

/// Fits the data with these effects. Returns null and adds a note if that fails.
std::unique_ptr<ExtendedFit> ForwardSelection::TryFit(
    const std::vector<HypothesisEvidence>& chosen) {
  try {
    return refit_(chosen);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    out_.notes.push_back("the flight cannot be adjusted with " + chosen.back().name +
                         " among the unknowns: " + error.what());
    return nullptr;
  }
}

void ForwardSelection::ReconsiderNoise() {
  std::vector<HypothesisEvidence> chosen = out_.chosen;
  bool changed = false;
  for (std::size_t k = 0; k + 1 < chosen.size(); ++k) {
    if (EffectRow(*chosen[k].id).fixed()) continue;
    const std::unique_ptr<ExtendedFit> others = TryFit(Without(k));
    const HypothesisEvidence* best = others ? Next(others->effects) : nullptr;
    const HypothesisEvidence* own = others ? FindByName(others->effects, chosen[k].name) : nullptr;
    if (best == nullptr || own == nullptr) continue;
    const bool another = best->log_evidence >= own->log_evidence + kReplacementLeadNats;
    const HypothesisEvidence refined = Refined(*others, another ? *best : *own);
    const double moved = std::abs(refined.estimate[0] - chosen[k].estimate[0]);
    if (!another && moved <= chosen[k].sigma[0]) continue;
    chosen[k] = refined;
    changed = true;
  }
  if (changed) Replace(chosen);
}

std::vector<HypothesisEvidence> ForwardSelection::Without(std::size_t k) const {
  std::vector<HypothesisEvidence> others = out_.chosen;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
  return others;
}

/// Returns the fit with all chosen effects but one; null if it fails.
const ExtendedFit* ForwardSelection::FitWithout(std::size_t k) {
  const std::size_t n = out_.chosen.size();
  if (n == 1) return out_.base.get();
  if (k + 1 == n && !revised_ && !before_.empty()) return before_.back().get();
  scratch_ = TryFit(Without(k));
  return scratch_.get();
}

void ForwardSelection::Replace(const std::vector<HypothesisEvidence>& chosen) {
  std::unique_ptr<ExtendedFit> next = TryFit(chosen);
  if (!next) return;
  out_.chosen = chosen;
  out_.final = std::move(next);
  revised_ = true;
  confirmed_.clear();
}

}  // namespace dn::diagnosis_internal
