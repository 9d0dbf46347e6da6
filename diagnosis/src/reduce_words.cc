#include "reduce_words.h"

namespace dn::diagnosis_internal {
namespace {

/// Returns the advice for an effect whose sensor has a certificate of its calibration.
std::string Certificate(const std::string& sensor, const std::string& name) {
  return "the " + name + " in the calibration certificate of the " + sensor +
         ", stated under `unmodelled`";
}

}  // namespace

std::string ReduceWords(EffectId effect) {
  switch (effect) {
    case EffectId::kGnssLeverArm:
      return "a survey of the antenna with a total station; turns of both senses";
    case EffectId::kLidarLeverArm:
      return "a survey of the scanner with a total station; strips at two heights";
    case EffectId::kGnssTimeOffset:
    case EffectId::kGnssTimeDrift:
      return "the delay of the receiver's time tags on the bench; changes of speed and turns";
    case EffectId::kLidarTimeOffset:
    case EffectId::kLidarTimeDrift:
      return "the delay of the scanner's time tags on the bench; strips at two speeds, flown in "
             "both directions";
    case EffectId::kGravityTilt:
      return "the deflection of the vertical from a geoid model, stated under `unmodelled`";
    case EffectId::kGravityDisturbance:
      return "the gravity disturbance from a gravity model, stated under `unmodelled`";
    case EffectId::kLidarRangeOffset:
    case EffectId::kLidarRangeScale:
      return "ranges to targets at known distances; strips at two heights";
    case EffectId::kLidarAngleScale:
    case EffectId::kLidarScanCone:
    case EffectId::kLidarScanTorsion:
      return Certificate("scanner", "scan angle errors") +
             "; crossing strips, and opposite strips with a large overlap";
    case EffectId::kBoresightDrift:
      return "a warm scanner before the first strip; the first strip flown again at the end";
    case EffectId::kGyroScaleFactor:
    case EffectId::kGyroMisalignment:
    case EffectId::kGyroGSensitivity:
      return Certificate("inertial unit", "gyro errors") +
             "; turns of both senses before the strips";
    case EffectId::kAccelScaleFactor:
    case EffectId::kAccelMisalignment:
      return Certificate("inertial unit", "accelerometer errors") +
             "; changes of speed and turns before the strips";
    default:
      return "a prior from its data sheet, stated under `unmodelled`";
  }
}

}  // namespace dn::diagnosis_internal
