#include <dn/blind_check/blind_score.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace dn {
namespace {

// Lists of names or numbers are written in one field, separated by blanks.

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
  for (const Effect& effect : record.effects) sizes.push_back(DrawnSize(effect));
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

/// Quotes a field, which may contain any character.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "\"";
}

}  // namespace

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
