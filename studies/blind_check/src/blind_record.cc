#include <dn/blind_check/blind_record.h>
#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "blind_json.h"

namespace dn {
namespace {

std::optional<double> NumberUnder(const JsonPlace& section, const char* key) {
  if (!section.Has(key)) return std::nullopt;
  return OptionalNumber(section.At(key));
}

/// Returns the rotation from the true boresight to an estimated one, deg.
Eigen::Vector3d BoresightErrorDeg(const Eigen::Vector3d& angles_deg,
                                  const Eigen::Vector3d& true_deg) {
  const Eigen::Quaterniond q = Exp(Eigen::Vector3d(kRadPerDeg * angles_deg));
  const Eigen::Quaterniond q_true = Exp(Eigen::Vector3d(kRadPerDeg * true_deg));
  return kDegPerRad * Log(Eigen::Quaterniond(q * q_true.conjugate()));
}

std::optional<BlindAverage> AverageFromJson(const JsonPlace& json,
                                            const Eigen::Vector3d& true_boresight_deg) {
  if (!json.Has("boresight_averaged") || json.At("boresight_averaged").is_null()) {
    return std::nullopt;
  }
  const JsonPlace averaged = json.At("boresight_averaged");
  const Eigen::Vector3d error_deg =
      BoresightErrorDeg(ReadVector3(averaged.At("angles_deg")), true_boresight_deg);
  const Eigen::Matrix3d covariance_deg2 = ReadMatrix3(averaged.At("covariance_deg2"));
  BlindAverage average;
  average.error_sigmas = error_deg.cwiseQuotient(ReadVector3(averaged.At("sigma_deg")));
  average.nees = error_deg.dot(covariance_deg2.ldlt().solve(error_deg));
  return average;
}

}  // namespace

BlindRecord MakeTruthRecord(const BlindFlight& flight) {
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

BlindDiagnosis DiagnosisFromGapJson(const JsonPlace& json,
                                    const Eigen::Vector3d& true_boresight_deg) {
  const JsonPlace gap = json.At("gap");
  const JsonPlace verdict = json.At("verdict");
  BlindDiagnosis diagnosis;
  diagnosis.detected = gap.At("detected").Flag();
  diagnosis.p_value = ReadNumberOrNaN(gap.At("p_value"));
  diagnosis.verdict = WordFromJson(verdict.At("kind"));
  diagnosis.effects = WordsFromJson(verdict.At("effects"));
  diagnosis.credible_set = WordsFromJson(verdict.At("credible_set"));
  diagnosis.unknown = verdict.At("unknown").Flag();
  diagnosis.causes = CausesFromJson(json.At("causes"));
  diagnosis.shrinkage = NumberUnder(json.At("shrinkage"), "fraction");
  if (gap.Has("size_nats_per_obs")) {
    diagnosis.size_nats_per_obs = NumberUnder(gap.At("size_nats_per_obs"), "value");
  }
  diagnosis.averaged = AverageFromJson(json, true_boresight_deg);
  return diagnosis;
}

BlindCalibration CalibrationFromResultJson(const JsonPlace& json,
                                           const Eigen::Vector3d& true_boresight_deg) {
  const JsonPlace boresight = json.At("boresight");
  const Eigen::Vector3d angles_deg = ReadVector3(boresight.At("angles_deg"));
  BlindCalibration calibration;
  calibration.verdict = WordFromJson(json.At("assessment").At("verdict"));
  calibration.sigma_deg = ReadVector3(boresight.At("sigma_deg"));
  const Eigen::Vector3d error_deg = BoresightErrorDeg(angles_deg, true_boresight_deg);
  calibration.error_sigmas = error_deg.cwiseQuotient(calibration.sigma_deg);
  return calibration;
}

const char* Word(BlindContent content) {
  switch (content) {
    case BlindContent::kNothing:
      return "nothing";
    case BlindContent::kOneEffect:
      return "one";
    case BlindContent::kTwoEffects:
      return "two";
    case BlindContent::kThreeEffects:
      return "three";
    case BlindContent::kLeftOut:
      return "left out";
    case BlindContent::kUnlistedEffect:
      return "outsider";
  }
  return "";
}

BlindContent RecordContent(const std::string& word) {
  for (const BlindContent content :
       {BlindContent::kNothing, BlindContent::kOneEffect, BlindContent::kTwoEffects,
        BlindContent::kThreeEffects, BlindContent::kUnlistedEffect, BlindContent::kLeftOut}) {
    if (word == Word(content)) return content;
  }
  throw InvalidInput("unknown content of a flight '" + word + "'");
}

}  // namespace dn
