#include <dn/diagnosis/gap_output.h>
#include <dn/geo/local_frame.h>
#include <dn/names.h>
#include <dn/report/wrapped.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "effect_words.h"

namespace dn {
namespace {

constexpr std::size_t kMaxPlaces = 5;
constexpr std::size_t kMaxCausesListed = 8;
constexpr double kLeastPosterior = 0.05;

std::string P(double p_value) { return fmt::format("{:.2g}", p_value); }

std::string Mm(const std::optional<double>& m) {
  return m ? fmt::format("{:.1f}", diagnosis_internal::kMmPerM * *m) : "-";
}

std::string SizeLines(const GapDiagnosis& d) {
  if (d.verdict.kind == GapVerdictKind::kUnavailable) return "";
  std::string text = fmt::format(
      "gap       {}, {} ({} replicates); {:.3g} nats per observation, {:.3g} .. {:.3g} without a "
      "gap,\n          at most {:.3g}\n",
      d.detected ? "yes" : "none found", diagnosis_internal::PWords(d.p_value),
      d.validity.replicates, d.size.value, d.size.null_low, d.size.null_high,
      d.size.upper_limit_95);
  const GapUserUnits& units = d.user_units;
  std::vector<std::string> parts;
  if (units.p2p_excess_m) parts.push_back(fmt::format("pairs {} mm", Mm(units.p2p_excess_m)));
  if (units.gnss_excess_m) parts.push_back(fmt::format("GNSS {} mm", Mm(units.gnss_excess_m)));
  if (units.boresight_inconsistency_rad) {
    parts.push_back(
        fmt::format("boresight between strip pairs {:.2g} mdeg",
                    diagnosis_internal::kMdegPerRad * *units.boresight_inconsistency_rad));
  }
  if (units.gh_minus_dn_rad) {
    parts.push_back("gh - dn " + diagnosis_internal::MdegWords(*units.gh_minus_dn_rad));
  }
  if (!parts.empty()) text += fmt::format("          beyond noise: {}\n", fmt::join(parts, ", "));
  return text;
}

std::string PlaceLines(const GapDiagnosis& d) {
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxPlaces, d.where.size()); ++i) {
    const GapLocation& place = d.where[i];
    text += fmt::format("{:<10}{} {}, {}: {:.3g} ({})\n", i == 0 ? "where" : "", place.sensor,
                        place.quantity, place.location, place.statistic,
                        diagnosis_internal::PWords(place.p_adjusted));
  }
  return text;
}

/// Returns the shifts of roll, pitch and yaw, mdeg.
std::string Moves(const GapDiagnosis& d, const GapCause& cause) {
  if (!diagnosis_internal::HasBoresight(d)) return "";
  if (cause.boresight_rad.isZero(0.0)) return "-";
  const std::string words = diagnosis_internal::MdegWords(cause.boresight_rad);
  return words.substr(0, words.rfind(' '));
}

std::string Mark(const GapVerdict& verdict, const std::string& effect) {
  return HasName(verdict.effects, effect) ? "*" : HasName(verdict.credible_set, effect) ? "?" : " ";
}

/// Returns the log evidence in nine columns.
std::string Nats(double log_evidence) {
  const bool fits = std::abs(log_evidence) < 999999.0;
  return fits ? fmt::format("{:>9.1f}", log_evidence) : fmt::format("{:>9.2e}", log_evidence);
}

/// Lists the unmodelled discrepancies that may be present.
std::string DiscrepancyLines(const GapDiagnosis& d) {
  std::string text;
  for (const GapDiscrepancy& one : d.discrepancies) {
    if (one.posterior < kLeastPosterior) continue;
    text += fmt::format("          {:<28}{:>6.2f}{}  unmodelled\n",
                        diagnosis_internal::DiscrepancyWords(one), one.posterior,
                        Nats(one.log_evidence));
  }
  return text;
}

std::string CauseLines(const GapDiagnosis& d) {
  if (d.causes.empty()) return "";
  const bool moves = diagnosis_internal::HasBoresight(d);
  std::string text = fmt::format("{:<10}{:<28}{:>6}{:>9}  {:<22} {}\n", "causes", "", "prob.",
                                 "nats", moves ? "shift [mdeg]" : "", "size");
  for (std::size_t i = 0; i < std::min(kMaxCausesListed, d.causes.size()); ++i) {
    const GapCause& cause = d.causes[i];
    const std::string weaker = diagnosis_internal::WeakerWords(d, cause);
    text += fmt::format(
        "        {} {:<28}{:>6.2f}{}  {:<22} {}{}{}\n", Mark(d.verdict, cause.effect), cause.effect,
        cause.posterior, Nats(cause.log_evidence), Moves(d, cause),
        diagnosis_internal::ValueWords(cause), diagnosis_internal::TimesWords(cause.times),
        weaker.empty() ? "" : "; " + weaker);
  }
  return text + DiscrepancyLines(d) + "          * in the verdict, ? equally possible" +
         (moves ? "; shift of roll, pitch, yaw if not modelled\n" : "\n");
}

std::string Angles(const GapState& state) {
  if (!state.boresight_rad) return "";
  const Eigen::Vector3d deg = kDegPerRad * *state.boresight_rad;
  std::string text = fmt::format("{:.5f}, {:.5f}, {:.5f}", deg.x(), deg.y(), deg.z());
  if (!state.boresight_sigma_rad) return text;
  const Eigen::Vector3d sigma = kDegPerRad * *state.boresight_sigma_rad;
  return text + fmt::format(" +- {:.5f}, {:.5f}, {:.5f}", sigma.x(), sigma.y(), sigma.z());
}

std::string StateLine(const char* name, const GapState& state) {
  return fmt::format("          {:<7} {:>8} {:>10.3g} {:>10} {:>10}  {}\n", name, P(state.p_value),
                     state.size_nats_per_obs, Mm(state.p2p_m), Mm(state.gnss_m), Angles(state));
}

std::string ShrinkageLines(const std::optional<GapShrinkage>& shrinkage) {
  if (!shrinkage) return "";
  std::string text = "closed    " + diagnosis_internal::ClosedWords(*shrinkage);
  if (shrinkage->share_of_reachable) {
    text += fmt::format(", {:.0f} % of the reachable gain", 100.0 * *shrinkage->share_of_reachable);
  }
  if (shrinkage->held_out_gain_nats) {
    text += fmt::format("; {:.1f} nats on held-out data", *shrinkage->held_out_gain_nats);
  }
  text += fmt::format("\n          {:<7} {:>8} {:>10} {:>10} {:>10}  {}\n", "", "p", "nats/obs",
                      "pairs mm", "GNSS mm", "boresight [deg]");
  return text + StateLine("before", shrinkage->before) + StateLine("after", shrinkage->after);
}

/// Returns the boresight over all hypotheses, and the probability of physics outside the library.
std::string AverageLines(const GapDiagnosis& d) {
  std::string text;
  if (d.detected) {
    text += fmt::format("outside   probability of something that is not in the library: {:.2f}\n",
                        d.outside_posterior);
  }
  if (!d.boresight_averaged) return text;
  GapState state;
  state.boresight_rad = d.boresight_averaged->angles_rad;
  state.boresight_sigma_rad = d.boresight_averaged->sigma_rad();
  return text + fmt::format("boresight {} deg, over all hypotheses\n", Angles(state));
}

std::string ValidityLines(const GapValidity& validity) {
  std::string text = "no replicates";
  if (validity.replicates > 0) {
    text = fmt::format("{} linear replicates (against each other {})", validity.replicates,
                       diagnosis_internal::PWords(validity.aa_p_value));
  }
  if (validity.simulated_replicates > 0)
    text += fmt::format(", {} simulated replicates", validity.simulated_replicates);
  if (validity.full_against_linear_p) {
    text += fmt::format(" (against the linear ones {})",
                        diagnosis_internal::PWords(*validity.full_against_linear_p));
  }
  if (validity.like_replicates_p) {
    text += fmt::format("; flight among replicates with the effects: p = {}",
                        P(*validity.like_replicates_p));
  }
  for (const std::string& note : validity.notes) text += "; " + note;
  return "trust     " + WrapText(text, "          ");
}

}  // namespace

std::string GapSummary(const GapDiagnosis& diagnosis) {
  const std::string head =
      fmt::format("flight {}: {}\n  ", diagnosis.flight, Word(diagnosis.verdict.kind)) +
      WrapText(diagnosis.verdict.text, "  ");
  if (diagnosis.verdict.kind == GapVerdictKind::kUnavailable)
    return head + DetectionLimitsSummary(diagnosis.could_still_hide,
                                         diagnosis_internal::HasBoresight(diagnosis));
  return head + SizeLines(diagnosis) + PlaceLines(diagnosis) + CauseLines(diagnosis) +
         ShrinkageLines(diagnosis.shrinkage) + AverageLines(diagnosis) +
         DetectionLimitsSummary(diagnosis.could_still_hide,
                                diagnosis_internal::HasBoresight(diagnosis)) +
         ValidityLines(diagnosis.validity);
}

}  // namespace dn
