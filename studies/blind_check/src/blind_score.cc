#include <dn/blind_check/blind_score.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/names.h>
#include <dn/quantile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace dn {
namespace {

constexpr double kAlarmLevel = 0.05;
constexpr double kBeyond_sigmas = 5.0;
constexpr double kQuickReplicates = 100.0;  // least number of replicates behind a p-value of dn gap
constexpr double kCovered_sigmas = 1.959963984540054;
constexpr const char* kAllVerdicts = "all";

bool Contains(const BlindRecord& record, const std::string& effect) {
  return std::any_of(record.effects.begin(), record.effects.end(),
                     [&](const Effect& there) { return there.name == effect; });
}

Quartiles ComputeQuartiles(const std::vector<double>& values) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (values.empty()) return {0, kNone, kNone, kNone};
  return {static_cast<long>(values.size()), Quantile(values, 0.25), Quantile(values, 0.5),
          Quantile(values, 0.75)};
}

/// Returns the entry of this name, which is appended if there is none.
template <class T>
T& Entry(const std::string& name, std::string T::*key, std::vector<T>* entries) {
  for (T& entry : *entries) {
    if (entry.*key == name) return entry;
  }
  entries->emplace_back();
  entries->back().*key = name;
  return entries->back();
}

const BlindCause* FindCause(const BlindDiagnosis& diagnosis, const std::string& effect) {
  for (const BlindCause& cause : diagnosis.causes) {
    if (cause.effect == effect) return &cause;
  }
  return nullptr;
}

constexpr std::array<double, 3> kSizeLimits{0.0, 2.154, 4.642};  // 10^(1/3), 10^(2/3)

constexpr std::array<double, 4> kStrengthLimits{0.0, 4.5, 6.0, 8.0};  // sigmas
constexpr std::array<double, 3> kSignatureLimits{0.0, 5.0, 8.0};

/// Returns the index of the last limit that is not above x.
template <std::size_t N>
std::size_t ClassIndex(double x, const std::array<double, N>& limits) {
  const auto above = std::upper_bound(limits.begin(), limits.end(), x);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, above - limits.begin()) - 1);
}

SignatureScore& FindSignatureScore(const BlindSignature& signature, BlindScore* score) {
  return score->signatures[ClassIndex(std::sqrt(signature.lambda_left), kSignatureLimits)];
}

template <class Score>
void Count(bool detected, bool named, bool with_group, Score* score) {
  score->detected.Count(detected);
  score->named.Count(named);
  score->named_with_group.Count(with_group);
}

/// Samples for the quantiles of the score.
struct Samples {
  std::vector<double> null_p_value, truth_posterior;
  std::vector<double> shrinkage_right, shrinkage_wrong;
  std::vector<double> diagnosis_time_s, calibration_time_s;
  std::array<double, 10> stated_sum{};
};

void CountVerdict(BlindContent content, const std::string& verdict,
                  std::vector<VerdictCount>* counts) {
  for (VerdictCount& count : *counts) {
    if (count.content != content || count.verdict != verdict) continue;
    ++count.flights;
    return;
  }
  counts->push_back({content, verdict, 1});
}

void ScoreNothing(const BlindDiagnosis& diagnosis, BlindScore* score, Samples* samples) {
  samples->null_p_value.push_back(diagnosis.p_value);
  score->false_alarms.Count(diagnosis.detected);
  score->false_names.Count(!diagnosis.effects.empty());
}

void ScoreOne(const BlindRecord& record, BlindScore* score, Samples* samples) {
  const BlindDiagnosis& diagnosis = *record.diagnosis.result;
  const std::string& effect = record.effects.front().name;
  const bool named = NamedStrictly(record), with_group = NamedWithGroup(record);
  score->one_detected.Count(diagnosis.detected);
  score->one_named.Count(named);
  score->one_named_with_group.Count(with_group);
  Count(diagnosis.detected, named, with_group,
        &Entry(effect, &EffectScore::effect, &score->effects));
  Count(diagnosis.detected, named, with_group,
        &score->sizes[ClassIndex(DrawnSize(record.effects.front()), kSizeLimits)]);
  if (record.signature) {
    StrengthScore& strength =
        score->strengths[ClassIndex(std::sqrt(record.signature->lambda), kStrengthLimits)];
    Count(diagnosis.detected, named, with_group, &strength);
    if (const auto& calibrated = record.calibrated.result) {
      strength.calibrated_beyond_5_sigma.Count(calibrated->verdict == "calibrated" &&
                                               calibrated->worst() > kBeyond_sigmas);
    }
  }
  const BlindCause* cause = FindCause(diagnosis, effect);
  if (diagnosis.detected) samples->truth_posterior.push_back(cause ? cause->posterior : 0.0);
}

void ScoreSeveral(const BlindRecord& record, SeveralScore* score) {
  const BlindDiagnosis& diagnosis = *record.diagnosis.result;
  Count(diagnosis.detected, NamedStrictly(record), NamedWithGroup(record), score);
  for (const Effect& effect : record.effects) {
    score->members.Count(HasName(diagnosis.effects, effect.name));
  }
}

/// Scores a flight with an effect that the diagnosis does not have.
void ScoreUnlistedEffect(const std::string& name, const BlindRecord& record, BlindScore* score) {
  const BlindDiagnosis& diagnosis = *record.diagnosis.result;
  UnlistedEffectScore& of_outsider = Entry(name, &UnlistedEffectScore::outsider, &score->outsiders);
  score->outsider_detected.Count(diagnosis.detected);
  of_outsider.detected.Count(diagnosis.detected);
  SignatureScore* of_signature =
      record.signature ? &FindSignatureScore(*record.signature, score) : nullptr;
  if (of_signature != nullptr) of_signature->detected.Count(diagnosis.detected);
  if (!diagnosis.detected) return;
  const bool rejected =
      diagnosis.unknown || diagnosis.verdict == "unknown" || diagnosis.verdict == "partial";
  score->outsider_rejected.Count(rejected);
  of_outsider.rejected.Count(rejected);
  const bool misnamed = !rejected && diagnosis.verdict == "identified";
  score->outsider_misnamed.Count(misnamed);
  if (of_signature == nullptr) return;
  of_signature->rejected.Count(rejected);
  of_signature->misnamed.Count(misnamed);
}

void ScoreReliability(const BlindRecord& record, BlindScore* score, Samples* samples) {
  for (const BlindCause& cause : record.diagnosis.result->causes) {
    if (std::isnan(cause.posterior)) continue;
    const auto tenth = static_cast<int>(10.0 * std::clamp(cause.posterior, 0.0, 1.0));
    const auto bin = static_cast<std::size_t>(std::min(tenth, 9));
    score->reliability[bin].true_causes.Count(Contains(record, cause.effect));
    samples->stated_sum[bin] += cause.posterior;
  }
}

void ScoreCoverage(const BlindRecord& record, BlindScore* score) {
  const BlindDiagnosis& diagnosis = *record.diagnosis.result;
  for (const Effect& effect : record.effects) {
    const BlindCause* cause = FindCause(diagnosis, effect.name);
    if (!HasName(diagnosis.effects, effect.name) || cause == nullptr) continue;
    const bool fixed = FindEffect(effect.name)->kind == EffectKind::kFixed;
    Share* coverage = fixed ? &score->fixed_coverage : &score->stochastic_coverage;
    const std::size_t count = std::min(cause->estimate.size(), cause->sigma.size());
    for (std::size_t i = 0; i < std::min(count, effect.value.size()); ++i) {
      if (!(cause->sigma[i] > 0.0) || std::isnan(cause->estimate[i])) continue;
      const double error = cause->estimate[i] - effect.value[i];
      coverage->Count(std::abs(error) <= kCovered_sigmas * cause->sigma[i]);
    }
  }
}

void ScoreSpurious(const BlindRecord& record, BlindScore* score) {
  if (record.effects.empty()) return;
  for (const std::string& name : record.diagnosis.result->effects) {
    score->spurious += Contains(record, name) ? 0 : 1;
  }
}

void ScoreShrinkage(const BlindRecord& record, Samples* samples) {
  const BlindDiagnosis& diagnosis = *record.diagnosis.result;
  if (!diagnosis.shrinkage || diagnosis.effects.empty()) return;
  (NamedStrictly(record) ? samples->shrinkage_right : samples->shrinkage_wrong)
      .push_back(*diagnosis.shrinkage);
}

void CountAverage(const BlindAverage& average, AverageScore* score) {
  const double most = ChiSquareQuantile(0.95, 3.0);
  score->in_region_95.Count(average.nees <= most);
  for (const double error : average.error_sigmas) {
    score->angles_95.Count(std::abs(error) <= kCovered_sigmas);
  }
}

void ScoreAverage(const BlindDiagnosis& diagnosis, BlindScore* score) {
  if (!diagnosis.averaged) return;
  for (const std::string& verdict : {diagnosis.verdict, std::string(kAllVerdicts)}) {
    CountAverage(*diagnosis.averaged, &Entry(verdict, &AverageScore::verdict, &score->averaged));
  }
}

void ScoreDiagnosis(const BlindRecord& record, BlindScore* score, Samples* samples) {
  CountVerdict(record.content, record.diagnosis.result->verdict, &score->verdicts);
  switch (record.content) {
    case BlindContent::kNothing:
      ScoreNothing(*record.diagnosis.result, score, samples);
      break;
    case BlindContent::kOneEffect:
      ScoreOne(record, score, samples);
      break;
    case BlindContent::kTwoEffects:
      ScoreSeveral(record, &score->two);
      break;
    case BlindContent::kThreeEffects:
      ScoreSeveral(record, &score->three);
      break;
    case BlindContent::kUnlistedEffect:
      ScoreUnlistedEffect(record.outsider->name, record, score);
      break;
    case BlindContent::kLeftOut:
      ScoreUnlistedEffect(record.effects.front().name, record, score);
      break;
  }
  ScoreReliability(record, score, samples);
  ScoreCoverage(record, score);
  ScoreSpurious(record, score);
  ScoreShrinkage(record, samples);
  ScoreAverage(*record.diagnosis.result, score);
  samples->diagnosis_time_s.push_back(record.diagnosis.time_s);
}

void ScoreCalibration(const BlindCalibration& calibration, std::vector<CalibrationScore>* scores) {
  CalibrationScore& score = Entry(calibration.verdict, &CalibrationScore::verdict, scores);
  ++score.flights;
  score.beyond_5_sigma += calibration.worst() > kBeyond_sigmas ? 1 : 0;
  score.rms_sigmas += calibration.error_sigmas.squaredNorm();  // sum of squares until the end
}

void Finish(std::vector<CalibrationScore>* scores) {
  std::sort(scores->begin(), scores->end(),
            [](const auto& a, const auto& b) { return a.verdict < b.verdict; });
  for (CalibrationScore& score : *scores) {
    score.rms_sigmas = std::sqrt(score.rms_sigmas / (3.0 * static_cast<double>(score.flights)));
  }
}

void AddFailure(const BlindRecord& record, const char* program, const std::string& failure,
                BlindScore* score) {
  if (failure.empty()) return;
  score->failures.push_back(fmt::format("flight {}: {}: {}", record.number, program, failure));
}

void Finish(const Samples& samples, BlindScore* score) {
  score->alarms_allowed = score->false_alarms.of == 0
                              ? Interval{0.0, 1.0}
                              : BinomialInterval(0.95, score->false_alarms.of, kAlarmLevel);
  for (std::size_t k = 0; k < score->reliability.size(); ++k) {
    ReliabilityBin& bin = score->reliability[k];
    bin.low = static_cast<double>(k) / 10.0;
    bin.high = static_cast<double>(k + 1) / 10.0;
    bin.stated = samples.stated_sum[k] / static_cast<double>(bin.true_causes.of);
  }
  for (std::size_t k = 0; k < score->sizes.size(); ++k) score->sizes[k].from = kSizeLimits[k];
  for (std::size_t k = 0; k < score->strengths.size(); ++k) {
    score->strengths[k].from_sigmas = kStrengthLimits[k];
  }
  for (std::size_t k = 0; k < score->signatures.size(); ++k) {
    score->signatures[k].from_sigmas = kSignatureLimits[k];
  }
  score->null_p_value = ComputeQuartiles(samples.null_p_value);
  if (!samples.null_p_value.empty()) {
    score->null_uniformity_p = UniformityPValue(samples.null_p_value, kQuickReplicates);
  }
  score->truth_posterior = ComputeQuartiles(samples.truth_posterior);
  score->shrinkage_right = ComputeQuartiles(samples.shrinkage_right);
  score->shrinkage_wrong = ComputeQuartiles(samples.shrinkage_wrong);
  score->diagnosis_time_s = ComputeQuartiles(samples.diagnosis_time_s);
  score->calibration_time_s = ComputeQuartiles(samples.calibration_time_s);
  Finish(&score->calibrated);
  Finish(&score->adapted);
  std::sort(score->verdicts.begin(), score->verdicts.end(), [](const auto& a, const auto& b) {
    return std::tie(a.content, a.verdict) < std::tie(b.content, b.verdict);
  });
  std::sort(score->averaged.begin(), score->averaged.end(), [](const auto& a, const auto& b) {
    return std::pair(a.verdict == kAllVerdicts, a.verdict) <
           std::pair(b.verdict == kAllVerdicts, b.verdict);
  });
  std::sort(score->effects.begin(), score->effects.end(),
            [](const auto& a, const auto& b) { return a.effect < b.effect; });
  std::sort(score->outsiders.begin(), score->outsiders.end(),
            [](const auto& a, const auto& b) { return a.outsider < b.outsider; });
}

}  // namespace

bool NamedStrictly(const BlindRecord& record) {
  if (!record.diagnosis.result || record.effects.empty()) return false;
  const std::vector<std::string>& named = record.diagnosis.result->effects;
  return named.size() == record.effects.size() &&
         std::all_of(named.begin(), named.end(),
                     [&](const std::string& name) { return Contains(record, name); });
}

bool NamedWithGroup(const BlindRecord& record) {
  if (!record.diagnosis.result || record.effects.empty()) return false;
  if (NamedStrictly(record)) return true;
  const BlindDiagnosis& diagnosis = *record.diagnosis.result;
  if (diagnosis.verdict != "group") return false;
  return std::all_of(record.effects.begin(), record.effects.end(), [&](const Effect& effect) {
    return HasName(diagnosis.effects, effect.name) || HasName(diagnosis.credible_set, effect.name);
  });
}

BlindScore ScoreBlindFlights(const std::vector<BlindRecord>& records) {
  if (records.empty()) throw InvalidInput("no flight to score: the list of records is empty");
  BlindScore score;
  Samples samples;
  score.flights = static_cast<long>(records.size());
  for (const BlindRecord& record : records) {
    AddFailure(record, "dn gap", record.diagnosis.failure, &score);
    AddFailure(record, "dn calibrate", record.calibrated.failure, &score);
    AddFailure(record, "dn calibrate, adapted", record.adapted.failure, &score);
    if (record.diagnosis.result) ScoreDiagnosis(record, &score, &samples);
    if (record.calibrated.result) {
      ScoreCalibration(*record.calibrated.result, &score.calibrated);
      samples.calibration_time_s.push_back(record.calibrated.time_s);
    }
    if (record.adapted.result) ScoreCalibration(*record.adapted.result, &score.adapted);
  }
  Finish(samples, &score);
  return score;
}

}  // namespace dn
