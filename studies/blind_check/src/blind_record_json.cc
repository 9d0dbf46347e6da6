#include <dn/error.h>
#include <dn/montecarlo/blind_record.h>

#include "json_numbers.h"

namespace dn {
namespace {

template <class T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

std::optional<double> OptionalNumber(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional<double>(json.get<double>());
}

Json EffectToJson(const Effect& effect) {
  Json json = {{"effect", effect.name}, {"value", effect.value}};
  if (effect.times.window_s) {
    json["window_s"] = {effect.times.window_s->first, effect.times.window_s->second};
  }
  if (effect.times.t0_s) json["t0_s"] = *effect.times.t0_s;
  return json;
}

Effect EffectFromJson(const Json& json) {
  Effect effect;
  effect.name = json.at("effect");
  effect.value = NumbersFromJson(json.at("value"));
  if (json.contains("window_s")) {
    effect.times.window_s = {json.at("window_s").at(0), json.at("window_s").at(1)};
  }
  if (json.contains("t0_s")) effect.times.t0_s = json.at("t0_s").get<double>();
  return effect;
}

Json SignatureToJson(const std::optional<BlindSignature>& signature) {
  if (!signature) return {};
  return {{"lambda", signature->lambda},
          {"lambda_left", signature->lambda_left},
          {"nearest", signature->nearest}};
}

std::optional<BlindSignature> SignatureFromJson(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return BlindSignature{json.at("lambda"), json.at("lambda_left"), json.at("nearest")};
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
          {"causes", causes}};
}

void ResultFromJson(const Json& json, BlindDiagnosis* diagnosis) {
  diagnosis->detected = json.at("detected");
  diagnosis->p_value = NumberFromJson(json.at("p_value"));
  diagnosis->verdict = json.at("verdict");
  diagnosis->effects = json.at("effects");
  diagnosis->credible_set = json.at("credible_set");
  diagnosis->unknown = json.at("unknown");
  diagnosis->shrinkage = OptionalNumber(json.at("shrinkage"));
  diagnosis->size_nats_per_obs = OptionalNumber(json.at("size_nats_per_obs"));
  for (const Json& cause : json.at("causes")) {
    diagnosis->causes.push_back({cause.at("effect"), NumberFromJson(cause.at("posterior")),
                                 NumbersFromJson(cause.at("estimate")),
                                 NumbersFromJson(cause.at("sigma"))});
  }
}

Json ResultToJson(const BlindCalibration& calibration) {
  return {{"verdict", calibration.verdict},
          {"error_sigmas", dn::ToJson(calibration.error_sigmas)},
          {"sigma_deg", dn::ToJson(calibration.sigma_deg)}};
}

void ResultFromJson(const Json& json, BlindCalibration* calibration) {
  calibration->verdict = json.at("verdict");
  calibration->error_sigmas = Vector3FromJson(json.at("error_sigmas"));
  calibration->sigma_deg = Vector3FromJson(json.at("sigma_deg"));
}

template <class T>
Json OutcomeToJson(const Outcome<T>& outcome) {
  return {{"result", outcome.result ? ResultToJson(*outcome.result) : Json()},
          {"failure", outcome.failure},
          {"time_s", outcome.time_s}};
}

template <class T>
Outcome<T> OutcomeFromJson(const Json& json) {
  Outcome<T> outcome;
  outcome.failure = json.at("failure");
  outcome.time_s = json.at("time_s");
  if (!json.at("result").is_null()) ResultFromJson(json.at("result"), &outcome.result.emplace());
  return outcome;
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

BlindRecord BlindRecordFromJson(const Json& json) {
  BlindRecord record;
  record.number = json.at("number");
  record.seed = json.at("seed");
  record.base = json.at("base");
  record.content = ContentOf(json.at("content"));
  for (const Json& effect : json.at("effects")) record.effects.push_back(EffectFromJson(effect));
  const Json& outsider = json.at("outsider");
  if (!outsider.is_null()) record.outsider = {outsider.at("name"), outsider.at("parameters")};
  record.boresight_deg = Vector3FromJson(json.at("boresight_deg"));
  record.strips = json.at("strips");
  record.signature = SignatureFromJson(json.at("signature"));
  record.diagnosis = OutcomeFromJson<BlindDiagnosis>(json.at("diagnosis"));
  record.calibrated = OutcomeFromJson<BlindCalibration>(json.at("calibrated"));
  record.adapted = OutcomeFromJson<BlindCalibration>(json.at("adapted"));
  return record;
}

}  // namespace dn
