#include <dn/builder/calibration_effect.h>
#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/gap_output.h>
#include <dn/effects/effect_table.h>
#include <dn/names.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "decision.h"
#include "effect_words.h"

namespace dn {
namespace {

using diagnosis_internal::Alternatives;
using diagnosis_internal::kUnlike;
using diagnosis_internal::MdegWords;
using diagnosis_internal::PWords;
using diagnosis_internal::ResultWord;
using diagnosis_internal::Rounded;

// A rest is called small if the named effects close more than this share of the gap.
constexpr double kMostOfTheGap = 0.9;
// A named effect below this probability is given with its best rival.
constexpr double kNearlyCertain = 0.9;

/// Returns what a user of the Gauss-Helmert adjustment can do, which estimates only the boresight.
std::string RemedyOnGivenTrajectory(const GapCause& cause) {
  const EstimableEffect* effect = FindEstimable(cause.effect);
  return effect == nullptr ? std::string("repair the data")
                           : std::string(effect->remedy) + " with the dynamic network";
}

std::string Remedy(const GapDiagnosis& d, const GapCause& cause) {
  const std::string key = AdaptedKey(cause.effect);
  if (key.empty()) return "no key of flight.yaml models it, so repair the data";
  if (key == "estimate" && d.trajectory_given) return RemedyOnGivenTrajectory(cause);
  if (key == "estimate") {
    const std::string times = FormatEffectTimes(cause.times);
    const std::string entry =
        times.empty() ? cause.effect : "{unknown: " + cause.effect + times + "}";
    return fmt::format("add {} to estimate in flight.yaml", entry);
  }
  return fmt::format("state it in {} of flight.yaml", key);
}

std::string ShiftText(const GapCause& cause) {
  const Eigen::Vector3d& max_shift_sigmas = cause.boresight_rad;
  return max_shift_sigmas.isZero(0.0) || !max_shift_sigmas.allFinite()
             ? std::string()
             : ", which moves the boresight (roll, pitch, yaw) by " + MdegWords(max_shift_sigmas);
}

/// Compares an effect with its prior: a tolerance of the sensor, or a fault.
std::string PriorWords(const GapCause& cause) {
  if (!cause.prior_sigmas) return "";
  return fmt::format(" ({} times its usual sigma, {})", Rounded(*cause.prior_sigmas, 2),
                     cause.within_prior() ? "a tolerance" : "a fault");
}

/// Describes one effect: name, size, shift of the boresight, and the key that models it.
std::string Effect(const GapDiagnosis& d, const GapCause& cause) {
  const std::string size = diagnosis_internal::ValueWords(cause);
  return fmt::format("{}{}{}{}{}: {}", cause.effect, size.empty() ? "" : " of " + size,
                     diagnosis_internal::TimesWords(cause.times), PriorWords(cause),
                     ShiftText(cause), Remedy(d, cause));
}

/// Returns the shift of the boresight by random effects, whose own shifts are not known.
std::string Moved(const GapDiagnosis& d) {
  const GapState& before = d.shrinkage->before;
  const GapState& after = d.shrinkage->after;
  if (!before.boresight_rad || !after.boresight_rad) return "";
  for (const GapCause& cause : VerdictCauses(d)) {
    if (!ShiftText(cause).empty()) return "";
  }
  return " and moves the boresight (roll, pitch, yaw) by " +
         MdegWords(*after.boresight_rad - *before.boresight_rad);
}

/// Returns the words for an effect of implausible size; "" if all sizes are plausible.
std::string ImplausibleWords(const GapDiagnosis& d) {
  if (!d.verdict.implausible) return "";
  const GapImplausible& one = *d.verdict.implausible;
  return fmt::format(
      "; {} has {:.0f} times its typical size, and {} fits the data almost equally well: check "
      "whether this size is possible",
      one.effect, one.typical_sizes, one.discrepancy);
}

std::string NamedEffects(const GapDiagnosis& d) {
  std::vector<std::string> each;
  for (const GapCause& cause : VerdictCauses(d)) each.push_back(Effect(d, cause));
  std::string text = fmt::format("the model lacks {}", fmt::join(each, "; and "));
  if (d.shrinkage)
    text += "; that closes " + diagnosis_internal::ClosedWords(*d.shrinkage) + Moved(d);
  return text + ImplausibleWords(d);
}

/// Returns the other effects that could explain the data.
std::vector<std::string> OtherNames(const GapDiagnosis& d) {
  const std::vector<std::string>& effects = d.verdict.effects;
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (!HasName(effects, name) && !HasName(names, name)) names.push_back(name);
  };
  for (const std::string& name : d.verdict.credible_set) add(name);
  for (const GapCause& cause : VerdictCauses(d)) {
    for (const std::string& name : cause.inseparable_from) add(name);
  }
  return names;
}

/// Returns whether all these effects are tolerances of the sensors; false for no effects.
bool AllTolerances(const GapDiagnosis& d, const std::vector<std::string>& effects) {
  return !effects.empty() &&
         std::all_of(effects.begin(), effects.end(), [&](const std::string& effect) {
           return std::any_of(d.causes.begin(), d.causes.end(), [&](const GapCause& cause) {
             return cause.effect == effect && cause.within_prior();
           });
         });
}

/// Returns the words for results that contain the tolerances of the sensors. The errors of a given
/// trajectory are not among them.
std::string ReliableWords(const GapDiagnosis& d) {
  std::string text = "which the results of dn calibrate contain in angles and sigmas";
  if (d.trajectory_given) return text;
  return text + fmt::format(", so that the {} is reliable", ResultWord(d));
}

/// Returns what follows for the reported boresight if all named effects are tolerances; "" if one
/// is a fault or random.
std::string ToleranceWords(const GapDiagnosis& d) {
  if (!AllTolerances(d, d.verdict.effects)) return "";
  const std::vector<std::string> others = OtherNames(d);
  if (d.verdict.unknown) {
    return "; the named effects are within the tolerance of the sensors, but the rest is not";
  }
  if (!others.empty() && !AllTolerances(d, others)) {
    return fmt::format("; {} would be within the tolerance of the sensors, others would not",
                       fmt::join(d.verdict.effects, " and "));
  }
  return "; this is within the tolerance of the sensors, " + ReliableWords(d);
}

std::string WithTieBreaker(const GapDiagnosis& d, const std::string& text) {
  return d.verdict.tie_breaker.empty() ? text : text + "; " + d.verdict.tie_breaker;
}

std::string Group(const GapDiagnosis& d) {
  const std::vector<std::string> others = OtherNames(d);
  const std::string inseparable =
      others.empty() ? "; this flight cannot separate them from each other"
                     : "; this flight cannot separate it from " + Alternatives(others);
  return WithTieBreaker(d, NamedEffects(d) + inseparable + ToleranceWords(d));
}

std::string Place(const GapDiagnosis& d) {
  if (d.where.empty()) return "";
  const GapLocation& first = d.where.front();
  return fmt::format(", mostly in {} {}, {}", first.sensor, first.quantity, first.location);
}

/// Returns the words for an unmodelled discrepancy that is more probable than not; "" if there is
/// none.
std::string WithoutName(const GapDiagnosis& d) {
  for (const GapDiscrepancy& one : d.discrepancies) {
    if (one.posterior > 0.5) {
      return fmt::format("; the best description is {}", diagnosis_internal::DiscrepancyWords(one));
    }
  }
  return "";
}

/// Describes a significant rest by its size.
std::string RestSize(const GapDiagnosis& d) {
  const GapState& after = d.shrinkage->after;
  std::string text =
      d.shrinkage->fraction > kMostOfTheGap ? "is small, but significant (" : "is significant (";
  text += PWords(after.p_value);
  if (after.size_nats_per_obs > 0.0) {
    text += fmt::format("; {} nats per observation", Rounded(after.size_nats_per_obs, 2));
  }
  return text + ")";
}

/// Returns the reasons why the named effects are not the whole explanation.
std::vector<std::string> RestReasons(const GapDiagnosis& d) {
  std::vector<std::string> reasons;
  if (d.shrinkage && d.shrinkage->after.p_value <= d.validity.alpha) {
    reasons.push_back(RestSize(d));
  }
  if (d.shrinkage && d.shrinkage->rest) {
    const GapDiscrepancy& rest = *d.shrinkage->rest;
    reasons.push_back(fmt::format("resembles {} ({} nats)",
                                  diagnosis_internal::DiscrepancyWords(rest),
                                  Rounded(rest.log_evidence, 3)));
  }
  if (d.validity.like_replicates_p.value_or(1.0) < kUnlike) {
    reasons.push_back(
        fmt::format("shows in simulated flights with the same effects, which differ "
                    "from this one ({})",
                    PWords(*d.validity.like_replicates_p)));
  }
  return reasons;
}

/// Returns the most probable unmodelled discrepancy if a single named effect is not nearly certain;
/// "" otherwise.
std::string DoubtWords(const GapDiagnosis& d) {
  for (const GapCause& cause : VerdictCauses(d)) {
    if (cause.posterior >= kNearlyCertain) continue;
    const auto rival =
        std::max_element(d.discrepancies.begin(), d.discrepancies.end(),
                         [](const auto& a, const auto& b) { return a.posterior < b.posterior; });
    if (rival == d.discrepancies.end() || rival->posterior < 0.5 * (1.0 - cause.posterior))
      continue;
    return fmt::format("; the probability of {} is {:.2f}, that of {} {:.2f}", cause.effect,
                       cause.posterior, diagnosis_internal::DiscrepancyWords(*rival),
                       rival->posterior);
  }
  return "";
}

/// Describes noise with heavy tails, and what to do.
std::string HeavyTailWords(const GapDiagnosis& d) {
  std::vector<std::string> each;
  for (const GapHeavyTails& tails : d.verdict.heavy_tails) {
    each.push_back(fmt::format(
        "the noise of {} has heavier tails than normal noise: Student's t with {} degrees of "
        "freedom and {} times the stated sigma describes it better than outliers, by {} nats; "
        "set {}.robust: cauchy in flight.yaml, which gives large residuals less weight",
        tails.sensor == "gnss" ? "the GNSS positions" : "the pairs", Rounded(tails.dof, 2),
        Rounded(tails.scale, 2), Rounded(tails.lead_nats, 3), tails.sensor));
  }
  return fmt::format("{}", fmt::join(each, "; "));
}

std::string Partial(const GapDiagnosis& d) {
  if (!d.verdict.rest && !d.verdict.heavy_tails.empty()) {
    return WithTieBreaker(d, NamedEffects(d) + "; " + HeavyTailWords(d));
  }
  std::string text = NamedEffects(d) + "; no effect of the library explains the rest of the gap";
  const std::vector<std::string> reasons = RestReasons(d);
  if (!reasons.empty()) text += fmt::format(", which {}", fmt::join(reasons, " and "));
  if (!Place(d).empty()) text += "; the gap is" + Place(d).substr(1);
  return WithTieBreaker(d, text + WithoutName(d) + ToleranceWords(d));
}

/// Returns the words for the best effect of the library, if it explains a part of the gap but less
/// than an unmodelled discrepancy does.
std::string LessThanDiscrepancy(const GapDiagnosis& d) {
  if (d.causes.empty()) return "";
  const GapCause& best = d.causes.front();
  const std::string weaker = diagnosis_internal::WeakerWords(d, best);
  return weaker.empty() ? "" : fmt::format("; {} explains a part, with {}", best.effect, weaker);
}

std::string Unknown(const GapDiagnosis& d) {
  if (!d.verdict.rest && !d.verdict.heavy_tails.empty()) {
    return fmt::format("the data differ from the assumed model ({}): {}", PWords(d.p_value),
                       HeavyTailWords(d));
  }
  return WithTieBreaker(
      d, fmt::format("the data differ from the assumed model ({}){}, and no effect of the library "
                     "explains all of it: do not use the {} before you have checked these data{}{}",
                     PWords(d.p_value), Place(d), ResultWord(d), WithoutName(d),
                     LessThanDiscrepancy(d)));
}

/// Returns the effect with the largest undetected shift of the boresight. On a given trajectory,
/// only effects that the pairs can show are considered.
DetectionLimit MostHarmful(const GapDiagnosis& d) {
  const std::vector<DetectionLimit> worst = diagnosis_internal::MostHarmful(d.could_still_hide);
  const auto at = std::find_if(worst.begin(), worst.end(), [&](const DetectionLimit& effect) {
    return !d.trajectory_given || std::isfinite(effect.minimal_detectable);
  });
  return at == worst.end() ? worst.front() : *at;
}

std::string NoGap(const GapDiagnosis& d) {
  std::string text =
      d.size.upper_limit_95 > 0.0
          ? fmt::format(
                "the data agree with the assumed model ({}; the gap is at most {:.2g} nats "
                "per observation)",
                PWords(d.p_value), d.size.upper_limit_95)
          : fmt::format("the data agree with the assumed model ({})", PWords(d.p_value));
  if (d.with_tolerances) text += " within the tolerance of the sensors, " + ReliableWords(d);
  if (d.could_still_hide.empty()) return text;
  const DetectionLimit worst = MostHarmful(d);
  if (!std::isfinite(worst.minimal_detectable)) {
    const auto more = std::count_if(
        d.could_still_hide.begin(), d.could_still_hide.end(),
        [](const DetectionLimit& effect) { return !std::isfinite(effect.minimal_detectable); });
    const std::string others = more < 2    ? ""
                               : more == 2 ? " and one other"
                                           : fmt::format(" and {} others", more - 1);
    return text + fmt::format("; undetectable at any size: {}{}", worst.effect, others);
  }
  text += fmt::format("; {} below {} is undetectable", worst.effect,
                      diagnosis_internal::DetectableWords(worst));
  if (!diagnosis_internal::HasBoresight(d)) return text;
  return text + ", and can shift the boresight (roll, pitch, yaw) by up to " +
         MdegWords(worst.boresight_rad.cwiseAbs());
}

std::string Unavailable(const GapDiagnosis& d) {
  const std::vector<std::string>& notes = d.validity.notes;
  return WithTieBreaker(
      d, notes.empty() ? "the flight cannot be diagnosed"
                       : fmt::format("the flight cannot be diagnosed: {}", fmt::join(notes, "; ")));
}

std::string KindText(const GapDiagnosis& diagnosis) {
  switch (diagnosis.verdict.kind) {
    case GapVerdictKind::kIdentified:
      return NamedEffects(diagnosis) + DoubtWords(diagnosis) + ToleranceWords(diagnosis);
    case GapVerdictKind::kGroup:
      return Group(diagnosis);
    case GapVerdictKind::kPartial:
      return Partial(diagnosis);
    case GapVerdictKind::kUnknown:
      return Unknown(diagnosis);
    case GapVerdictKind::kNoGap:
      return NoGap(diagnosis);
    case GapVerdictKind::kUnavailable:
      return Unavailable(diagnosis);
  }
  return {};
}

}  // namespace

std::string UnexplainedWords(const GapDiagnosis& d) {
  if (!d.verdict.unknown || (!d.verdict.rest && !d.verdict.heavy_tails.empty())) return "";
  return fmt::format("{} of a gap ({}){}{}", d.verdict.effects.empty() ? "all" : "a part",
                     PWords(d.p_value), Place(d), WithoutName(d));
}

std::string VerdictSentence(const GapDiagnosis& diagnosis) {
  const std::string text = KindText(diagnosis);
  const bool hides =
      diagnosis.trajectory_given && diagnosis.verdict.kind != GapVerdictKind::kUnavailable;
  return hides ? text +
                     "; errors of GNSS and of the inertial sensors, and an attitude offset, are "
                     "part of the given trajectory and undetectable here"
               : text;
}

}  // namespace dn
