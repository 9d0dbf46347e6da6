#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/montecarlo/blind_record.h>
#include <dn/rotation.h>

#include <algorithm>

#include <dn/report/json_numbers.h>

namespace dn {
namespace {

BlindCause CauseFromJson(const Json& json) {
  return {json.at("effect"), NumberFromJson(json.at("posterior")),
          NumbersFromJson(json.at("estimate")), NumbersFromJson(json.at("sigma"))};
}

std::optional<double> NumberUnder(const Json& section, const char* key) {
  if (section.is_null() || !section.contains(key) || section.at(key).is_null()) return std::nullopt;
  return section.at(key).get<double>();
}

BlindDiagnosis ReadDiagnosis(const Json& json) {
  const Json& gap = json.at("gap");
  const Json& verdict = json.at("verdict");
  BlindDiagnosis diagnosis;
  diagnosis.detected = gap.at("detected");
  diagnosis.p_value = NumberFromJson(gap.at("p_value"));
  diagnosis.verdict = verdict.at("kind");
  diagnosis.effects = verdict.at("effects");
  diagnosis.credible_set = verdict.at("credible_set");
  diagnosis.unknown = verdict.at("unknown");
  for (const Json& cause : json.at("causes")) diagnosis.causes.push_back(CauseFromJson(cause));
  diagnosis.shrinkage = NumberUnder(json.at("shrinkage"), "fraction");
  diagnosis.size_nats_per_obs = NumberUnder(gap.value("size_nats_per_obs", Json()), "value");
  return diagnosis;
}

BlindCalibration ReadCalibration(const Json& json, const Eigen::Vector3d& truth_deg) {
  const Json& boresight = json.at("boresight");
  const Eigen::Vector3d angles_deg = Vector3FromJson(boresight.at("angles_deg"));
  BlindCalibration calibration;
  calibration.verdict = json.at("assessment").at("verdict");
  calibration.sigma_deg = Vector3FromJson(boresight.at("sigma_deg"));
  const Eigen::Quaterniond q = Exp(Eigen::Vector3d(kRadPerDeg * angles_deg));
  const Eigen::Quaterniond q_true = Exp(Eigen::Vector3d(kRadPerDeg * truth_deg));
  const Eigen::Vector3d error_rad = Log(Eigen::Quaterniond(q * q_true.conjugate()));
  calibration.error_sigmas = kDegPerRad * error_rad.cwiseQuotient(calibration.sigma_deg);
  return calibration;
}

}  // namespace

BlindRecord TruthOf(const BlindFlight& flight) {
  BlindRecord record;
  record.number = flight.number;
  record.seed = flight.seed;
  record.base = flight.base;
  record.content = flight.content();
  record.effects = flight.scenario.effects;
  record.outsider = flight.outsider;
  record.boresight_deg = kDegPerRad * flight.scenario.lidar.mounting.boresight_rad;
  record.strips = flight.scenario.plan.lines.size();
  return record;
}

BlindDiagnosis DiagnosisFromGapJson(const Json& gap) {
  try {
    return ReadDiagnosis(gap);
  } catch (const Json::exception& error) {
    throw InvalidInput(std::string("not a gap.json: ") + error.what());
  }
}

BlindCalibration CalibrationFromResultJson(const Json& result,
                                           const Eigen::Vector3d& true_boresight_deg) {
  try {
    return ReadCalibration(result, true_boresight_deg);
  } catch (const Json::exception& error) {
    throw InvalidInput(std::string("not a result.json: ") + error.what());
  }
}

const char* Word(BlindContent content) {
  switch (content) {
    case BlindContent::kNothing:
      return "nothing";
    case BlindContent::kOneEffect:
      return "one";
    case BlindContent::kTwoEffects:
      return "two";
    case BlindContent::kLeftOut:
      return "left out";
    case BlindContent::kOutsider:
      return "outsider";
  }
  return "";
}

BlindContent ContentOf(const std::string& word) {
  for (const BlindContent content :
       {BlindContent::kNothing, BlindContent::kOneEffect, BlindContent::kTwoEffects,
        BlindContent::kOutsider, BlindContent::kLeftOut}) {
    if (word == Word(content)) return content;
  }
  throw InvalidInput("unknown content of a flight '" + word + "'");
}

}  // namespace dn
