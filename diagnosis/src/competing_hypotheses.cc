#include "competing_hypotheses.h"

#include <dn/names.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

constexpr double kCredible = 0.95;
/// Probability of unmodelled discrepancies above which no effect is named.
constexpr double kWithoutName = 0.5;

/// Returns the smallest set of names with the stated probability, given that some effect is
/// present.
std::vector<std::string> CredibleSet(const std::vector<HypothesisEvidence>& effects,
                                     const std::vector<double>& posterior) {
  std::vector<std::size_t> order(effects.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return posterior[a] > posterior[b]; });
  double all = 0.0;
  for (std::size_t k = 0; k < effects.size(); ++k) all += posterior[k];
  std::vector<std::string> names;
  double sum = 0.0;
  for (const std::size_t k : order) {
    if (sum >= kCredible * all) break;
    sum += posterior[k];
    if (effects[k].physical()) names.push_back(effects[k].name);
  }
  return names;
}

double ProbabilityIn(const CompetingHypotheses& set, const std::string& name) {
  for (std::size_t k = 0; k < set.competing_effects.size(); ++k) {
    if (set.competing_effects[k].name == name) return set.posterior.own[k];
  }
  return 0.0;
}

double ProbabilityInAny(const std::vector<CompetingHypotheses>& sets, const std::string& name) {
  double absent = 1.0;
  for (const CompetingHypotheses& set : sets) absent *= 1.0 - ProbabilityIn(set, name);
  return 1.0 - absent;
}

void TakeHypotheses(const CompetingHypotheses& set, GapCause* cause) {
  const double log_evidence = FindEvidence(set.competing_effects, cause->effect);
  if (std::isfinite(log_evidence)) cause->log_evidence = log_evidence;
  for (const std::string& name : set.credible_set) {
    if (name != cause->effect) cause->inseparable_from.push_back(name);
  }
}

/// Returns whether an unmodelled discrepancy is the more probable explanation. It must also fit the
/// data as well as the effect does; a more suitable typical size is not enough.
bool Doubtful(const CompetingHypotheses& set) {
  if (set.discrepancy_posterior <= kWithoutName) return false;
  const auto own = std::find_if(set.competing_effects.begin(), set.competing_effects.end(),
                                [&](const auto& other) { return other.name == set.effect; });
  const auto discrepancy = std::max_element(
      set.competing_effects.begin(), set.competing_effects.end(), [](const auto& a, const auto& b) {
        return a.physical() != b.physical() ? a.physical() : a.log_evidence < b.log_evidence;
      });
  return own == set.competing_effects.end() || discrepancy->statistic >= own->statistic;
}

std::vector<std::string> CredibleInAny(const std::vector<CompetingHypotheses>& sets) {
  std::vector<std::string> names;
  for (const CompetingHypotheses& set : sets) {
    for (const std::string& name : set.credible_set) {
      if (!HasName(names, name)) names.push_back(name);
    }
  }
  return names;
}

}  // namespace

CompetingHypotheses MakeCompetingHypotheses(
    const std::string& effect, const std::vector<HypothesisEvidence>& competing_effects,
    const HypothesisPrior& prior) {
  CompetingHypotheses set;
  set.effect = effect;
  set.competing_effects = competing_effects;
  set.posterior = ComputePosterior(competing_effects, prior);
  set.credible_set = CredibleSet(competing_effects, set.posterior.own);
  for (std::size_t k = 0; k < competing_effects.size(); ++k) {
    set.differing.push_back(DifferingShare(prior, competing_effects[k].log_evidence));
    if (!competing_effects[k].physical()) set.discrepancy_posterior += set.posterior.own[k];
  }
  return set;
}

void FillCauses(const std::vector<HypothesisEvidence>& screened,
                const std::vector<CompetingHypotheses>& sets, const std::vector<GapCause>& named,
                GapDiagnosis* diagnosis) {
  for (const GapCause& cause : named) {
    diagnosis->causes.push_back(cause);
    for (const CompetingHypotheses& set : sets) {
      if (set.effect == cause.effect) TakeHypotheses(set, &diagnosis->causes.back());
    }
  }
  for (const HypothesisEvidence& effect : screened) {
    if (!effect.physical()) {
      diagnosis->discrepancies.push_back(ToDiscrepancy(effect));
      continue;
    }
    const auto taken = std::any_of(named.begin(), named.end(), [&](const GapCause& cause) {
      return cause.effect == effect.name;
    });
    if (taken) continue;
    diagnosis->causes.push_back(ToCause(effect));
  }
  SetProbabilities(sets, diagnosis);
}

void SetProbabilities(const std::vector<CompetingHypotheses>& sets, GapDiagnosis* diagnosis) {
  for (GapCause& cause : diagnosis->causes) {
    const auto own = std::find_if(sets.begin(), sets.end(),
                                  [&](const auto& set) { return set.effect == cause.effect; });
    cause.posterior = own == sets.end() ? ProbabilityInAny(sets, cause.effect)
                                        : ProbabilityIn(*own, cause.effect);
  }
  for (GapDiscrepancy& one : diagnosis->discrepancies) {
    one.posterior = ProbabilityInAny(sets, one.name);
  }
  double inside = 1.0;
  for (const CompetingHypotheses& set : sets) inside *= 1.0 - set.posterior.outside;
  diagnosis->outside_posterior = 1.0 - inside;
}

GapVerdict Decide(const Decision& decision, const std::vector<std::string>& named,
                  const std::vector<CompetingHypotheses>& sets) {
  GapVerdict verdict;
  if (!decision.detected) return verdict;
  const bool doubtful = std::any_of(sets.begin(), sets.end(), Doubtful);
  if (named.empty() || decision.discrepancy_is_better || (named.size() == 1 && doubtful)) {
    verdict.kind = GapVerdictKind::kUnknown;
    verdict.unknown = true;
    if (!named.empty()) verdict.credible_set = CredibleInAny(sets);
    return verdict;
  }
  verdict.effects = named;
  verdict.credible_set = CredibleInAny(sets);
  const bool group = std::any_of(sets.begin(), sets.end(), [](const CompetingHypotheses& set) {
    return set.credible_set.size() > 1;
  });
  verdict.kind = group ? GapVerdictKind::kGroup : GapVerdictKind::kIdentified;
  if (decision.gap_remains || doubtful) {
    verdict.kind = GapVerdictKind::kPartial;
    verdict.unknown = true;
  }
  return verdict;
}

}  // namespace dn::diagnosis_internal
