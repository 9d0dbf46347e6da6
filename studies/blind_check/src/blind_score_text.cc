#include <dn/blind_check/blind_score.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dn {
namespace {

std::string Percent(double share) {
  return std::isnan(share) ? std::string("-") : fmt::format("{:.1f}", 100.0 * share);
}

std::string Line(const std::string& name, const Share& share) {
  const Interval interval = share.interval_95();
  return fmt::format("  {:<44} {:>4} of {:<4} {:>6} %  ({} .. {})\n", name, share.hits, share.of,
                     Percent(share.value()), Percent(interval.low), Percent(interval.high));
}

std::string Line(const std::string& name, const Quartiles& q) {
  if (q.count == 0) return fmt::format("  {:<44} none\n", name);
  return fmt::format("  {:<44} {:>4} flights, median {:.4g}, quartiles {:.4g} and {:.4g}\n", name,
                     q.count, q.median, q.low, q.high);
}

std::string Lines(const std::string& title, const std::vector<CalibrationScore>& scores) {
  if (scores.empty()) return {};
  std::string text = title + "\n";
  for (const CalibrationScore& score : scores) {
    text += fmt::format("  {:<16} {:>4} flights, {:>4} beyond 5 sigma, rms {:.3g} sigma\n",
                        score.verdict, score.flights, score.beyond_5_sigma, score.rms_sigmas);
  }
  return text;
}

std::string Lines(const std::vector<AverageScore>& scores) {
  if (scores.empty()) return {};
  std::string text = "boresight of dn gap, averaged over all hypotheses, by its verdict\n";
  for (const AverageScore& score : scores) {
    text += Line(score.verdict + ", within the 95 % region", score.in_region_95);
    text += Line(score.verdict + ", angles within 1.96 sigma", score.angles_95);
  }
  return text;
}

std::string Fraction(const Share& share) { return fmt::format("{}/{}", share.hits, share.of); }

template <class Score>
std::string FormatRow(const std::string& name, const Score& score) {
  return fmt::format("  {:<28} {:>9} {:>9} {:>12}\n", name, Fraction(score.detected),
                     Fraction(score.named), Fraction(score.named_with_group));
}

std::string EffectLines(const BlindScore& s) {
  std::string text;
  if (!s.effects.empty()) {
    text += fmt::format(
        "flights with one effect, by its size / typical size\n"
        "  {:<28} {:>9} {:>9} {:>12}\n",
        "", "detected", "named", "with groups");
    text += FormatRow("below 2.2", s.sizes[0]) + FormatRow("2.2 to 4.6", s.sizes[1]) +
            FormatRow("above 4.6", s.sizes[2]) + "by effect\n";
  }
  for (const EffectScore& score : s.effects) text += FormatRow(score.effect, score);
  if (!s.outsiders.empty()) {
    text += fmt::format("by effect that the diagnosis does not have\n  {:<28} {:>9} {:>9}\n", "",
                        "detected", "rejected");
  }
  for (const UnlistedEffectScore& score : s.outsiders) {
    text += fmt::format("  {:<28} {:>9} {:>9}\n", score.outsider, Fraction(score.detected),
                        Fraction(score.rejected));
  }
  return text;
}

std::string StrengthLines(const BlindScore& s) {
  const auto any = std::any_of(s.strengths.begin(), s.strengths.end(),
                               [](const StrengthScore& score) { return score.detected.of > 0; });
  if (!any) return {};
  std::string text = "flights with one fixed effect, by signal strength in sigmas\n" +
                     fmt::format("  {:<28} {:>9} {:>9} {:>12} {:>24}\n", "", "detected", "named",
                                 "with groups", "calibrated beyond 5");
  const std::array<const char*, 4> names{"below 4.5", "4.5 to 6", "6 to 8", "above 8"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const StrengthScore& score = s.strengths[k];
    text += fmt::format("  {:<28} {:>9} {:>9} {:>12} {:>24}\n", names[k], Fraction(score.detected),
                        Fraction(score.named), Fraction(score.named_with_group),
                        Fraction(score.calibrated_beyond_5_sigma));
  }
  return text;
}

std::string SignatureLines(const BlindScore& s) {
  const auto any = std::any_of(s.signatures.begin(), s.signatures.end(),
                               [](const SignatureScore& score) { return score.detected.of > 0; });
  if (!any) return {};
  std::string text =
      "by the signature that no fixed effect of the table explains, in sigmas\n" +
      fmt::format("  {:<28} {:>9} {:>9} {:>12}\n", "", "detected", "rejected", "one named");
  const std::array<const char*, 3> names{"below 5", "5 to 8", "above 8"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const SignatureScore& score = s.signatures[k];
    text += fmt::format("  {:<28} {:>9} {:>9} {:>12}\n", names[k], Fraction(score.detected),
                        Fraction(score.rejected), Fraction(score.misnamed));
  }
  return text;
}

std::string VerdictLines(const BlindScore& s) {
  if (s.verdicts.empty()) return {};
  std::string text = "true content, verdict, number of flights\n";
  for (const VerdictCount& count : s.verdicts) {
    text +=
        fmt::format("  {:<10} {:<14} {:>5}\n", Word(count.content), count.verdict, count.flights);
  }
  return text;
}

std::string ReliabilityLines(const BlindScore& s) {
  std::string text =
      "posterior of a cause, all flights: stated probability and observed frequency\n"
      "  between        causes   stated   observed\n";
  for (const ReliabilityBin& bin : s.reliability) {
    if (bin.true_causes.of == 0) continue;
    const Interval interval = bin.true_causes.interval_95();
    text += fmt::format("  {:.1f} .. {:.1f}  {:>8}   {:.3f}    {:.3f}  ({:.3f} .. {:.3f})\n",
                        bin.low, bin.high, bin.true_causes.of, bin.stated, bin.true_causes.value(),
                        interval.low, interval.high);
  }
  return text;
}

std::string SeveralLines(const std::string& heading, const SeveralScore& score) {
  return heading + Line("detected", score.detected) + Line("all named, no other", score.named) +
         Line("all named, or in the credible set", score.named_with_group) +
         Line("each effect", score.members);
}

}  // namespace

std::string FormatTable(const BlindScore& s) {
  std::string text = fmt::format(
      "{} blind flights; 95 % confidence intervals in brackets\nflights without effects\n",
      s.flights);
  text += Line("false alarms", s.false_alarms);
  text += fmt::format("  {:<44} {} .. {} %\n", "95 % interval at a level of 5 %",
                      Percent(s.alarms_allowed.low), Percent(s.alarms_allowed.high));
  text += Line("an effect is named", s.false_names);
  text += Line("p-values", s.null_p_value);
  if (s.null_p_value.count > 0) {
    text += fmt::format("  {:<44} p {:.2g}\n", "test of uniform p-values", s.null_uniformity_p);
  }
  text += "flights with one effect\n";
  text += Line("detected", s.one_detected);
  text += Line("named alone", s.one_named);
  text += Line("named, or in the credible set of a group", s.one_named_with_group);
  text += Line("posterior of the effect, if detected", s.truth_posterior);
  text += SeveralLines("flights with two effects\n", s.two);
  if (s.three.detected.of > 0) text += SeveralLines("flights with three effects\n", s.three);
  text += fmt::format("named effects that are absent, in flights with effects: {}\n", s.spurious);
  text += "flights with an effect that the diagnosis does not have\n";
  text += Line("detected", s.outsider_detected);
  text += Line("of these, verdict unknown or partial", s.outsider_rejected);
  text += Line("of these, verdict a wrong effect", s.outsider_misnamed);
  text += "estimates of correctly named effects within 1.96 sigma\n";
  text += Line("fixed effects, components", s.fixed_coverage);
  text += Line("ratios, sigmas, correlation times", s.stochastic_coverage);
  text += "closed share of the gap\n";
  text += Line("with the correct effects", s.shrinkage_right);
  text += Line("with wrong effects", s.shrinkage_wrong);
  text += VerdictLines(s);
  text += ReliabilityLines(s);
  text += Lines("boresight of dn calibrate, by its verdict", s.calibrated);
  text += Lines("boresight of the adapted flight, by its verdict", s.adapted);
  text += Lines(s.averaged);
  text += EffectLines(s) + StrengthLines(s) + SignatureLines(s);
  for (const std::string& failure : s.failures) text += failure + "\n";
  return text;
}

}  // namespace dn
