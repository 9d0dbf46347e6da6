#include "effect_words.h"

#include <dn/effects/effect_table.h>
#include <dn/geo/local_frame.h>
#include <dn/names.h>
#include <dn/report/value_words.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "decision.h"

namespace dn::diagnosis_internal {
namespace {

constexpr double kLeastP = 1e-12;
constexpr double kImprobable = 0.05;

std::string Size(const GapCause& cause, Eigen::Index i) {
  const bool known = i < cause.sigma.size() && std::isfinite(cause.sigma[i]);
  return known ? FormatWithSigma(cause.estimate[i], cause.sigma[i]) : Rounded(cause.estimate[i], 3);
}

std::string Unit(const std::string& unit) { return unit == "1" ? "" : " " + unit; }

bool ShareUnit(const std::vector<EffectComponent>& parts) {
  return std::all_of(parts.begin(), parts.end(),
                     [&](const EffectComponent& part) { return part.unit == parts.front().unit; });
}

/// Returns whether a component has the same text as the one before it, such as equal sigmas on all
/// axes.
bool RepeatsTheOneBefore(const EffectSpec& spec, const GapCause& cause, Eigen::Index i) {
  if (i == 0) return false;
  const auto k = static_cast<std::size_t>(i);
  return spec.components[k].unit == spec.components[k - 1].unit &&
         Size(cause, i) == Size(cause, i - 1);
}

/// Returns whether no size was measured, such as that of outliers where no datum was rejected.
bool Unmeasured(const GapCause& cause) {
  return cause.estimate.isZero(0.0) && cause.sigma.isZero(0.0);
}

/// Returns a share in percent. Only 1 itself becomes "100".
std::string Percent(double share) {
  const double percent = 100.0 * share;
  for (int digits = 0; digits <= 2; ++digits) {
    std::string text = fmt::format("{:.{}f}", percent, digits);
    if (percent >= 100.0 || std::stod(text) < 100.0) return text;
  }
  return "more than 99.99";
}

double PossibleShift(const DetectionLimit& effect) {
  const double shift = effect.boresight_rad.norm();
  return std::isfinite(shift) ? shift : std::numeric_limits<double>::infinity();
}

}  // namespace

std::string Rounded(double value, int digits) {
  return fmt::format("{:g}", std::stod(fmt::format("{:.{}e}", value, digits - 1)));
}

std::string PWords(double p_value) {
  return p_value < kLeastP ? "p < 1e-12" : "p = " + Rounded(p_value, 2);
}

bool HasBoresight(const GapDiagnosis& diagnosis) {
  const auto moves = [](const auto& effect) { return !effect.boresight_rad.isZero(0.0); };
  return std::any_of(diagnosis.causes.begin(), diagnosis.causes.end(), moves) ||
         std::any_of(diagnosis.could_still_hide.begin(), diagnosis.could_still_hide.end(), moves);
}

const char* ResultWord(const GapDiagnosis& diagnosis) {
  return HasBoresight(diagnosis) ? "boresight" : "trajectory";
}

std::string ValueWords(const GapCause& cause) {
  if (Unmeasured(cause)) return "";
  const EffectSpec* spec = FindEffect(cause.effect);
  const bool known =
      spec != nullptr && spec->components.size() == static_cast<std::size_t>(cause.estimate.size());
  const bool named = known && !ShareUnit(spec->components);
  std::string text;
  for (Eigen::Index i = 0; i < cause.estimate.size(); ++i) {
    if (named && RepeatsTheOneBefore(*spec, cause, i)) continue;
    if (i > 0) text += ", ";
    if (!named) {
      text += Size(cause, i);
      continue;
    }
    const EffectComponent& part = spec->components[static_cast<std::size_t>(i)];
    const bool for_more = i + 1 < cause.estimate.size() && RepeatsTheOneBefore(*spec, cause, i + 1);
    const std::string name = for_more ? part.name.substr(0, part.name.find(' ')) : part.name;
    text += name + " " + Size(cause, i) + Unit(part.unit);
  }
  return named || text.empty() ? text : text + Unit(cause.unit);
}

std::string TimesWords(const EffectTimes& times) {
  if (times.window_s) {
    return fmt::format(" from {:.10g} to {:.10g} s", times.window_s->first, times.window_s->second);
  }
  return times.t0_s ? fmt::format(" from {:.10g} s on", *times.t0_s) : "";
}

std::string DiscrepancyWords(const GapDiscrepancy& discrepancy) {
  if (discrepancy.period_s) {
    return fmt::format("{}, {:.0f} s", discrepancy.name, *discrepancy.period_s);
  }
  return discrepancy.tau_s ? fmt::format("{}, tau {:.0f} s", discrepancy.name, *discrepancy.tau_s)
                           : discrepancy.name;
}

std::string DetectableWords(const DetectionLimit& effect) {
  const Eigen::VectorXd& sizes = effect.detectable_by_component;
  const EffectSpec* spec = FindEffect(effect.effect);
  if (sizes.size() < 2 || spec == nullptr) {
    return Rounded(effect.minimal_detectable, 2) + " " + effect.unit;
  }
  std::vector<std::string> each, names;
  for (Eigen::Index k = 0; k < sizes.size(); ++k) {
    each.push_back(std::isfinite(sizes[k]) ? Rounded(sizes[k], 2) : "any");
    names.push_back(spec->components[static_cast<std::size_t>(k)].name);
  }
  return fmt::format("{} {} ({} alone)", fmt::join(each, ", "), effect.unit,
                     fmt::join(names, ", "));
}

std::string MdegWords(const Eigen::Vector3d& rad) {
  const Eigen::Vector3d mdeg = kMdegPerRad * rad;
  return Rounded(mdeg.x(), 2) + ", " + Rounded(mdeg.y(), 2) + ", " + Rounded(mdeg.z(), 2) + " mdeg";
}

std::string Alternatives(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  }
  return text;
}

std::string ClosedWords(const GapShrinkage& shrinkage) {
  if (!(shrinkage.fraction > 0.0)) return "nothing of the gap";
  const double low = shrinkage.interval_low, high = std::clamp(shrinkage.interval_high, 0.0, 1.0);
  return fmt::format("{} % of the gap ({} to {})", Percent(shrinkage.fraction),
                     low < 0.0 ? "below 0" : Percent(low), Percent(high));
}

std::string WeakerWords(const GapDiagnosis& diagnosis, const GapCause& cause) {
  const bool named = HasName(diagnosis.verdict.effects, cause.effect);
  if (cause.posterior >= kImprobable || cause.log_evidence < kLeastThresholdNats) return "";
  if (!named && !diagnosis.verdict.effects.empty() && cause.left_nats) {
    return fmt::format("{:.1f} nats are left with the named effects", *cause.left_nats);
  }
  const auto best = std::max_element(
      diagnosis.discrepancies.begin(), diagnosis.discrepancies.end(),
      [](const auto& a, const auto& b) { return a.log_evidence < b.log_evidence; });
  if (best == diagnosis.discrepancies.end() || best->log_evidence <= cause.log_evidence) return "";
  return fmt::format("{:.1f} nats less than {}", best->log_evidence - cause.log_evidence,
                     best->name);
}

std::vector<DetectionLimit> MostHarmful(std::vector<DetectionLimit> effects) {
  std::stable_sort(effects.begin(), effects.end(),
                   [](const DetectionLimit& a, const DetectionLimit& b) {
                     return PossibleShift(a) > PossibleShift(b);
                   });
  return effects;
}

}  // namespace dn::diagnosis_internal
