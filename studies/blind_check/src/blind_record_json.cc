#include <dn/blind_check/blind_record.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>

#include "blind_json.h"

namespace dn {
namespace {

template <class T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

// Limits far above the numbers of any flight.
constexpr std::int64_t kMostFlights = 1'000'000;
constexpr std::int64_t kMostStrips = 100'000;
constexpr double kMostTime_s = 1e9;

Json EffectToJson(const Effect& effect) {
  Json json = {{"effect", effect.name}, {"value", effect.value}};
  if (effect.times.window_s) {
    json["window_s"] = {effect.times.window_s->first, effect.times.window_s->second};
  }
  if (effect.times.t0_s) json["t0_s"] = *effect.times.t0_s;
  return json;
}

Effect EffectFromJson(const JsonPlace& json) {
  Effect effect;
  effect.name = WordFromJson(json.At("effect"));
  for (const JsonPlace& value : json.At("value").Elements()) effect.value.push_back(value.Number());
  const EffectSpec* spec = FindEffect(effect.name);
  if (spec == nullptr) json.At("effect").Fail("is not an effect of the table");
  if (spec->components.size() != effect.value.size()) {
    json.At("value").Fail("has a different number of values than the effect");
  }
  if (json.Has("window_s")) {
    const JsonPlace window = json.At("window_s");
    effect.times.window_s = {window.At(0).Number(), window.At(1).Number()};
  }
  if (json.Has("t0_s")) effect.times.t0_s = json.At("t0_s").Number();
  return effect;
}

Json SignatureToJson(const std::optional<BlindSignature>& signature) {
  if (!signature) return {};
  return {{"lambda", signature->lambda},
          {"lambda_left", signature->lambda_left},
          {"nearest", signature->nearest}};
}

std::optional<BlindSignature> SignatureFromJson(const JsonPlace& json) {
  if (json.is_null()) return std::nullopt;
  return BlindSignature{json.At("lambda").Number(), json.At("lambda_left").Number(),
                        json.At("nearest").Text()};
}

Json AverageToJson(const std::optional<BlindAverage>& average) {
  if (!average) return {};
  return {{"error_sigmas", dn::ToJson(average->error_sigmas)}, {"nees", average->nees}};
}

std::optional<BlindAverage> AverageFromJson(const JsonPlace& json) {
  if (json.is_null()) return std::nullopt;
  return BlindAverage{ReadVector3(json.At("error_sigmas")), json.At("nees").Number()};
}

Json ResultToJson(const BlindDiagnosis& diagnosis) {
  Json causes = Json::array();
  for (const BlindCause& cause : diagnosis.causes) {
    causes.push_back({{"effect", cause.effect},
                      {"posterior", cause.posterior},
                      {"estimate", cause.estimate},
                      {"sigma", cause.sigma}});
  }
  return {{"detected", diagnosis.detected},
          {"p_value", diagnosis.p_value},
          {"verdict", diagnosis.verdict},
          {"effects", diagnosis.effects},
          {"credible_set", diagnosis.credible_set},
          {"unknown", diagnosis.unknown},
          {"shrinkage", OrNull(diagnosis.shrinkage)},
          {"size_nats_per_obs", OrNull(diagnosis.size_nats_per_obs)},
          {"averaged", AverageToJson(diagnosis.averaged)},
          {"causes", causes}};
}

void ResultFromJson(const JsonPlace& json, BlindDiagnosis* diagnosis) {
  diagnosis->detected = json.At("detected").Flag();
  diagnosis->p_value = ReadNumberOrNaN(json.At("p_value"));
  diagnosis->verdict = WordFromJson(json.At("verdict"));
  diagnosis->effects = WordsFromJson(json.At("effects"));
  diagnosis->credible_set = WordsFromJson(json.At("credible_set"));
  diagnosis->unknown = json.At("unknown").Flag();
  diagnosis->shrinkage = OptionalNumber(json.At("shrinkage"));
  diagnosis->size_nats_per_obs = OptionalNumber(json.At("size_nats_per_obs"));
  diagnosis->averaged = AverageFromJson(json.At("averaged"));
  diagnosis->causes = CausesFromJson(json.At("causes"));
}

Json ResultToJson(const BlindCalibration& calibration) {
  return {{"verdict", calibration.verdict},
          {"error_sigmas", dn::ToJson(calibration.error_sigmas)},
          {"sigma_deg", dn::ToJson(calibration.sigma_deg)}};
}

void ResultFromJson(const JsonPlace& json, BlindCalibration* calibration) {
  calibration->verdict = WordFromJson(json.At("verdict"));
  calibration->error_sigmas = ReadVector3(json.At("error_sigmas"));
  calibration->sigma_deg = ReadVector3(json.At("sigma_deg"));
}

template <class T>
Json OutcomeToJson(const Outcome<T>& outcome) {
  return {{"result", outcome.result ? ResultToJson(*outcome.result) : Json()},
          {"failure", outcome.failure},
          {"time_s", outcome.time_s}};
}

template <class T>
Outcome<T> OutcomeFromJson(const JsonPlace& json) {
  Outcome<T> outcome;
  outcome.failure = json.At("failure").Text();
  outcome.time_s = json.At("time_s").Number(0.0, kMostTime_s);
  const JsonPlace result = json.At("result");
  if (!result.is_null()) ResultFromJson(result, &outcome.result.emplace());
  return outcome;
}

// Returns whether the effects of a record agree with its `content`, because the score relies on
// `content`.
bool FitsContent(const BlindRecord& record) {
  if (record.content == BlindContent::kUnlistedEffect) return record.outsider.has_value();
  return record.effects.size() == EffectCount(record.content);
}

}  // namespace

Json ToJson(const BlindRecord& record) {
  Json effects = Json::array();
  for (const Effect& effect : record.effects) effects.push_back(EffectToJson(effect));
  Json outsider;
  if (record.outsider) {
    outsider = {{"name", record.outsider->name}, {"parameters", record.outsider->parameters}};
  }
  return {{"number", record.number},
          {"seed", record.seed},
          {"base", record.base},
          {"content", Word(record.content)},
          {"effects", effects},
          {"outsider", outsider},
          {"boresight_deg", dn::ToJson(record.boresight_deg)},
          {"strips", record.strips},
          {"signature", SignatureToJson(record.signature)},
          {"diagnosis", OutcomeToJson(record.diagnosis)},
          {"calibrated", OutcomeToJson(record.calibrated)},
          {"adapted", OutcomeToJson(record.adapted)}};
}

BlindRecord BlindRecordFromJson(const JsonPlace& json) {
  BlindRecord record;
  record.number = static_cast<int>(json.At("number").Integer(1, kMostFlights));
  record.seed = json.At("seed").Unsigned();
  record.base = json.At("base").Text();
  try {
    record.content = RecordContent(json.At("content").Text());
  } catch (const InvalidInput&) {
    json.At("content").Fail("is not one of the known contents of a flight");
  }
  for (const JsonPlace& effect : json.At("effects").Elements()) {
    record.effects.push_back(EffectFromJson(effect));
  }
  const JsonPlace outsider = json.At("outsider");
  if (!outsider.is_null()) {
    record.outsider = {WordFromJson(outsider.At("name")), outsider.At("parameters").json()};
  }
  record.boresight_deg = ReadFiniteVector3(json.At("boresight_deg"));
  record.strips = static_cast<std::size_t>(json.At("strips").Integer(0, kMostStrips));
  record.signature = SignatureFromJson(json.At("signature"));
  record.diagnosis = OutcomeFromJson<BlindDiagnosis>(json.At("diagnosis"));
  record.calibrated = OutcomeFromJson<BlindCalibration>(json.At("calibrated"));
  record.adapted = OutcomeFromJson<BlindCalibration>(json.At("adapted"));
  if (!FitsContent(record)) json.At("content").Fail("contradicts the keys effects and outsider");
  return record;
}

}  // namespace dn
