#include "unavailable.h"

#include <dn/diagnosis/gap_output.h>
#include <dn/effects/effect_table.h>

#include <limits>
#include <utility>

#include "library.h"

namespace dn::diagnosis_internal {
namespace {

GapResult WithoutVerdict(const Flight& flight, GapDiagnosis diagnosis) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  diagnosis.p_value = unknown;
  diagnosis.size = {unknown, unknown, unknown, unknown};
  diagnosis.verdict.kind = GapVerdictKind::kUnavailable;
  diagnosis.validity.aa_p_value = unknown;
  GapResult result;
  result.diagnosis = std::move(diagnosis);
  result.adapted = flight.config;
  return result;
}

}  // namespace

GapResult Unavailable(const Flight& flight, const GapOptions& options, const std::string& missing) {
  GapDiagnosis diagnosis;
  diagnosis.flight = flight.config.name;
  diagnosis.trajectory_given = !flight.imu.has_value();
  diagnosis.validity.alpha = options.alpha;
  diagnosis.validity.notes.push_back(missing);
  GapResult result = WithoutVerdict(flight, std::move(diagnosis));
  result.diagnosis.verdict.text = VerdictSentence(result.diagnosis);
  return result;
}

GapResult WithLimits(const Flight& flight, GapDiagnosis diagnosis) {
  diagnosis.validity.notes.push_back("no measured values were used");
  GapResult result = WithoutVerdict(flight, std::move(diagnosis));
  result.diagnosis.verdict.text =
      "detection limits from the geometry alone; no measured values were used, so there is no "
      "verdict";
  return result;
}

std::vector<DetectionLimit> EffectsInTrajectory(const GapOptions& options) {
  const LibraryOptions wanted = MakeLibraryOptions(options);
  std::vector<DetectionLimit> hidden;
  for (const EffectSpec& spec : EffectTable()) {
    const bool of_trajectory = spec.sensor == EffectSensor::kTrajectory;
    const bool of_lidar =
        spec.sensor == EffectSensor::kLidar || spec.sensor == EffectSensor::kPairs;
    const bool inertial = !of_lidar && spec.kind == EffectKind::kFixed;
    if (!(of_trajectory || inertial) || !wanted.Wanted(spec.name)) continue;
    DetectionLimit effect;
    effect.effect = spec.name;
    effect.unit = spec.components.front().unit;
    effect.minimal_detectable = std::numeric_limits<double>::infinity();
    effect.boresight_rad.setConstant(std::numeric_limits<double>::quiet_NaN());
    hidden.push_back(effect);
  }
  return hidden;
}

}  // namespace dn::diagnosis_internal
