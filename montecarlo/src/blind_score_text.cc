#include <dn/montecarlo/blind_score.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dn {
namespace {

Json ToJson(const Share& share) {
  const Interval interval = share.interval_95();
  return {{"hits", share.hits},
          {"of", share.of},
          {"share", share.value()},
          {"interval_95", {interval.low, interval.high}}};
}

Json ToJson(const Quartiles& q) {
  return {{"count", q.count}, {"low", q.low}, {"median", q.median}, {"high", q.high}};
}

Json ToJson(const std::vector<CalibrationScore>& scores) {
  Json rows = Json::array();
  for (const CalibrationScore& score : scores) {
    rows.push_back({{"verdict", score.verdict},
                    {"flights", score.flights},
                    {"beyond_5_sigma", score.beyond_5_sigma},
                    {"rms_sigmas", score.rms_sigmas}});
  }
  return rows;
}

Json ToJson(const std::vector<VerdictCount>& counts) {
  Json rows = Json::array();
  for (const VerdictCount& count : counts) {
    rows.push_back(
        {{"content", Word(count.content)}, {"verdict", count.verdict}, {"flights", count.flights}});
  }
  return rows;
}

Json ToJson(const std::vector<EffectScore>& effects) {
  Json rows = Json::array();
  for (const EffectScore& score : effects) {
    rows.push_back({{"effect", score.effect},
                    {"detected", ToJson(score.detected)},
                    {"named", ToJson(score.named)},
                    {"named_with_group", ToJson(score.named_with_group)}});
  }
  return rows;
}

Json ToJson(const std::array<SizeScore, 3>& sizes) {
  Json rows = Json::array();
  for (const SizeScore& score : sizes) {
    rows.push_back({{"from", score.from},
                    {"detected", ToJson(score.detected)},
                    {"named", ToJson(score.named)},
                    {"named_with_group", ToJson(score.named_with_group)}});
  }
  return rows;
}

Json ToJson(const std::vector<OutsiderScore>& outsiders) {
  Json rows = Json::array();
  for (const OutsiderScore& score : outsiders) {
    rows.push_back({{"outsider", score.outsider},
                    {"detected", ToJson(score.detected)},
                    {"rejected", ToJson(score.rejected)}});
  }
  return rows;
}

Json ToJson(const std::array<StrengthScore, 4>& strengths) {
  Json rows = Json::array();
  for (const StrengthScore& score : strengths) {
    rows.push_back({{"from_sigmas", score.from_sigmas},
                    {"detected", ToJson(score.detected)},
                    {"named", ToJson(score.named)},
                    {"named_with_group", ToJson(score.named_with_group)},
                    {"calibrated_beyond_5_sigma", ToJson(score.calibrated_beyond_5_sigma)}});
  }
  return rows;
}

Json ToJson(const std::array<SignatureScore, 3>& signatures) {
  Json rows = Json::array();
  for (const SignatureScore& score : signatures) {
    rows.push_back({{"from_sigmas", score.from_sigmas},
                    {"detected", ToJson(score.detected)},
                    {"rejected_of_detected", ToJson(score.rejected)},
                    {"misnamed_of_detected", ToJson(score.misnamed)}});
  }
  return rows;
}

Json ToJson(const std::array<ReliabilityBin, 10>& bins) {
  Json rows = Json::array();
  for (const ReliabilityBin& bin : bins) {
    rows.push_back({{"low", bin.low},
                    {"high", bin.high},
                    {"stated", bin.stated},
                    {"true", ToJson(bin.true_ones)}});
  }
  return rows;
}

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

std::string Fraction(const Share& share) { return fmt::format("{}/{}", share.hits, share.of); }

template <class Score>
std::string RowOf(const std::string& name, const Score& score) {
  return fmt::format("  {:<28} {:>9} {:>9} {:>12}\n", name, Fraction(score.detected),
                     Fraction(score.named), Fraction(score.named_with_group));
}

std::string EffectLines(const BlindScore& s) {
  std::string text;
  if (!s.effects.empty()) {
    text += fmt::format(
        "flights with one effect, by its size in usual sizes\n"
        "  {:<28} {:>9} {:>9} {:>12}\n",
        "", "detected", "named", "with groups");
    text += RowOf("below 2.2", s.sizes[0]) + RowOf("2.2 to 4.6", s.sizes[1]) +
            RowOf("above 4.6", s.sizes[2]) + "by effect\n";
  }
  for (const EffectScore& score : s.effects) text += RowOf(score.effect, score);
  if (!s.outsiders.empty()) {
    text += fmt::format("by outsider\n  {:<28} {:>9} {:>9}\n", "", "detected", "rejected");
  }
  for (const OutsiderScore& score : s.outsiders) {
    text += fmt::format("  {:<28} {:>9} {:>9}\n", score.outsider, Fraction(score.detected),
                        Fraction(score.rejected));
  }
  return text;
}

std::string StrengthLines(const BlindScore& s) {
  const auto any = std::any_of(s.strengths.begin(), s.strengths.end(),
                               [](const StrengthScore& score) { return score.detected.of > 0; });
  if (!any) return {};
  std::string text = "flights with one fixed effect, by how strongly it shows, in sigmas\n" +
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
      "by what of it no fixed effect of the table can mimic, in sigmas\n" +
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
  std::string text = "what is there, the verdict, flights\n";
  for (const VerdictCount& count : s.verdicts) {
    text +=
        fmt::format("  {:<10} {:<14} {:>5}\n", Word(count.content), count.verdict, count.flights);
  }
  return text;
}

std::string ReliabilityLines(const BlindScore& s) {
  std::string text =
      "posterior of a cause, all flights: stated, and how often it is there\n"
      "  between        causes   stated   there\n";
  for (const ReliabilityBin& bin : s.reliability) {
    if (bin.true_ones.of == 0) continue;
    const Interval interval = bin.true_ones.interval_95();
    text += fmt::format("  {:.1f} .. {:.1f}  {:>8}   {:.3f}    {:.3f}  ({:.3f} .. {:.3f})\n",
                        bin.low, bin.high, bin.true_ones.of, bin.stated, bin.true_ones.value(),
                        interval.low, interval.high);
  }
  return text;
}

// CSV: what holds names or numbers in lists separates them by blanks.

std::string Words(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

std::string TruthWords(const BlindRecord& record) {
  if (record.outsider) return record.outsider->name;
  std::vector<std::string> names;
  for (const Effect& effect : record.effects) names.push_back(effect.name);
  return names.empty() ? "nothing" : Words(names);
}

std::string TruthValues(const BlindRecord& record) {
  std::vector<std::string> values;
  for (const Effect& effect : record.effects) {
    values.push_back(fmt::format("{:.6g}", fmt::join(effect.value, " ")));
  }
  return fmt::format("{}", fmt::join(values, " | "));
}

std::string Sizes(const BlindRecord& record) {
  std::vector<double> sizes;
  for (const Effect& effect : record.effects) sizes.push_back(SizeOf(effect));
  return fmt::format("{:.3g}", fmt::join(sizes, " "));
}

std::string Field(const std::optional<double>& value) {
  return value && !std::isnan(*value) ? fmt::format("{:.6g}", *value) : std::string();
}

std::string DiagnosisFields(const BlindRecord& record) {
  if (!record.diagnosis.result) return ",,,,,,,";
  const BlindDiagnosis& d = *record.diagnosis.result;
  std::string posteriors;
  for (const Effect& effect : record.effects) {
    for (const BlindCause& cause : d.causes) {
      if (cause.effect != effect.name) continue;
      posteriors += (posteriors.empty() ? "" : " ") + Field(cause.posterior);
    }
  }
  const std::string best =
      d.causes.empty() ? "" : d.causes.front().effect + " " + Field(d.causes.front().posterior);
  return fmt::format("{},{},{},{},{},{},{},{}", d.detected ? 1 : 0, Field(d.p_value), d.verdict,
                     Words(d.effects), Words(d.credible_set), posteriors, best, Field(d.shrinkage));
}

std::string CalibrationFields(const Outcome<BlindCalibration>& outcome) {
  if (!outcome.result) return ",,,";
  const BlindCalibration& c = *outcome.result;
  return fmt::format("{},{:.3f},{:.3f},{:.3f}", c.verdict, c.error_sigmas[0], c.error_sigmas[1],
                     c.error_sigmas[2]);
}

std::string SignatureFields(const std::optional<BlindSignature>& signature) {
  if (!signature) return ",,";
  return fmt::format("{:.4g},{:.4g},{}", signature->lambda, signature->lambda_left,
                     signature->nearest);
}

/// A field that may hold anything.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "\"";
}

}  // namespace

Json ToJson(const BlindScore& s) {
  return {{"schema", "dn.blind_check/1"},
          {"flights", s.flights},
          {"failures", s.failures},
          {"nothing",
           {{"false_alarms", ToJson(s.false_alarms)},
            {"allowed_95", {s.alarms_allowed.low, s.alarms_allowed.high}},
            {"false_names", ToJson(s.false_names)},
            {"p_value", ToJson(s.null_p_value)},
            {"uniformity_p", s.null_uniformity_p}}},
          {"verdicts", ToJson(s.verdicts)},
          {"one_effect",
           {{"detected", ToJson(s.one_detected)},
            {"named", ToJson(s.one_named)},
            {"named_with_group", ToJson(s.one_named_with_group)},
            {"posterior_of_the_truth", ToJson(s.truth_posterior)}}},
          {"two_effects",
           {{"detected", ToJson(s.two_detected)},
            {"named", ToJson(s.two_named)},
            {"named_with_group", ToJson(s.two_named_with_group)},
            {"members", ToJson(s.two_members)}}},
          {"spurious_names", s.spurious},
          {"outsider",
           {{"detected", ToJson(s.outsider_detected)},
            {"rejected_of_detected", ToJson(s.outsider_rejected)},
            {"misnamed_of_detected", ToJson(s.outsider_misnamed)}}},
          {"by_size", ToJson(s.sizes)},
          {"by_strength", ToJson(s.strengths)},
          {"by_effect", ToJson(s.effects)},
          {"by_outsider", ToJson(s.outsiders)},
          {"by_signature", ToJson(s.signatures)},
          {"reliability", ToJson(s.reliability)},
          {"coverage_95",
           {{"fixed", ToJson(s.fixed_coverage)}, {"stochastic", ToJson(s.stochastic_coverage)}}},
          {"boresight", {{"assumed", ToJson(s.calibrated)}, {"adapted", ToJson(s.adapted)}}},
          {"shrinkage",
           {{"right_name", ToJson(s.shrinkage_right)}, {"wrong_name", ToJson(s.shrinkage_wrong)}}}};
}

std::string FormatTable(const BlindScore& s) {
  std::string text = fmt::format(
      "{} blind flights; in brackets what agrees with a share at 95 %\nflights with nothing\n",
      s.flights);
  text += Line("false alarms", s.false_alarms);
  text += fmt::format("  {:<44} {} .. {} %\n", "a level of 5 % gives 95 % of the time",
                      Percent(s.alarms_allowed.low), Percent(s.alarms_allowed.high));
  text += Line("an effect is named", s.false_names);
  text += Line("p-values", s.null_p_value);
  if (s.null_p_value.count > 0) {
    text += fmt::format("  {:<44} p {:.2g}\n", "uniform, as they should be", s.null_uniformity_p);
  }
  text += "flights with one effect\n";
  text += Line("detected", s.one_detected);
  text += Line("named, and nothing else", s.one_named);
  text += Line("named, or in the credible set of a group", s.one_named_with_group);
  text += Line("posterior of the effect, where detected", s.truth_posterior);
  text += "flights with two effects\n";
  text += Line("detected", s.two_detected);
  text += Line("both named, and nothing else", s.two_named);
  text += Line("both named, or in the credible set", s.two_named_with_group);
  text += Line("each effect", s.two_members);
  text += fmt::format("names of what is not there, in flights with effects: {}\n", s.spurious);
  text += "flights with physics outside the table, or with an effect left out\n";
  text += Line("detected", s.outsider_detected);
  text += Line("of these unknown or partial", s.outsider_rejected);
  text += Line("of these one effect named, nothing open", s.outsider_misnamed);
  text += "estimates of rightly named effects within 1.96 sigma\n";
  text += Line("fixed effects, components", s.fixed_coverage);
  text += Line("ratios, sigmas, correlation times", s.stochastic_coverage);
  text += "share of the gap that closes\n";
  text += Line("with the right name", s.shrinkage_right);
  text += Line("with another", s.shrinkage_wrong);
  text += VerdictLines(s);
  text += ReliabilityLines(s);
  text += Lines("boresight of dn calibrate, by its verdict", s.calibrated);
  text += Lines("boresight of the adapted flight, by its verdict", s.adapted);
  text += EffectLines(s) + StrengthLines(s) + SignatureLines(s);
  for (const std::string& failure : s.failures) text += failure + "\n";
  return text;
}

std::string FormatCsv(const std::vector<BlindRecord>& records) {
  std::string text =
      "flight,seed,scenario,strips,content,truth,value,size,detected,p_value,verdict,effects,"
      "credible_set,posterior_of_truth,best_cause,shrinkage,named,named_with_group,"
      "calibrate,z_roll,z_pitch,z_yaw,adapted,adapted_z_roll,adapted_z_pitch,adapted_z_yaw,"
      "lambda,lambda_left,nearest,failure\n";
  for (const BlindRecord& r : records) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", r.number, r.seed, r.base,
                        r.strips, Word(r.content), TruthWords(r), TruthValues(r), Sizes(r),
                        DiagnosisFields(r), NamedStrictly(r) ? 1 : 0, NamedWithGroup(r) ? 1 : 0,
                        CalibrationFields(r.calibrated), CalibrationFields(r.adapted),
                        SignatureFields(r.signature), Quoted(r.diagnosis.failure));
  }
  return text;
}

}  // namespace dn
