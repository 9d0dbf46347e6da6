#include <dn/study/sweep.h>

namespace dn {
namespace {

constexpr double kMostFigure = 1e18;

double Size(const JsonPlace& place) { return place.Number(0.0, kMostFigure); }

double Correlation(const JsonPlace& place) {
  constexpr double kRounding = 1e-6;
  return place.Number(0.0, 1.0 + kRounding);
}

}  // namespace

Json ToJson(const SweepRecord& record) {
  return {{"number", record.number},
          {"labels", record.labels},
          {"failure", record.failure},
          {"sigma_rad", ToJson(record.sigma_rad)},
          {"condition_number", record.condition_number},
          {"correlation_angles", record.correlation_angles},
          {"correlation_biases", record.correlation_biases},
          {"roll_pitch_rad", record.strips.roll_pitch_rad},
          {"yaw_rad", record.strips.yaw_rad},
          {"position_m", record.strips.position_m}};
}

SweepRecord SweepRecordFromJson(const JsonPlace& json) {
  SweepRecord record;
  record.number = json.At("number").Unsigned();
  record.labels = ReadTexts(json.At("labels"));
  record.failure = json.At("failure").Text();
  record.sigma_rad = ReadFiniteVector3(json.At("sigma_rad"));
  record.condition_number = Size(json.At("condition_number"));
  record.correlation_angles = Correlation(json.At("correlation_angles"));
  record.correlation_biases = Correlation(json.At("correlation_biases"));
  record.strips = {Size(json.At("roll_pitch_rad")), Size(json.At("yaw_rad")),
                   Size(json.At("position_m"))};
  const bool positive = record.sigma_rad.minCoeff() > 0.0;
  if (record.failure.empty() && !positive) {
    json.At("sigma_rad").Fail("is not positive in a design that determines the boresight");
  }
  return record;
}

}  // namespace dn
