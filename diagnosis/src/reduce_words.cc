#include "reduce_words.h"

namespace dn::diagnosis_internal {
std::string ReduceWords(EffectId effect) {
  switch (effect) {
    case EffectId::kGnssLeverArm:
      return "survey by total station; turns both ways";
    case EffectId::kGnssCorrelatedNoise:
      return "a nearer base station; more strips, flown at other times";
    case EffectId::kLidarLeverArm:
      return "survey by total station; strips at two heights";
    case EffectId::kGnssTimeOffset:
    case EffectId::kGnssTimeDrift:
    case EffectId::kLidarTimeOffset:
    case EffectId::kLidarTimeDrift:
      return "bench test of the time tags; strips at two speeds";
    case EffectId::kGravityTilt:
      return "deflections of the vertical from a geoid model";
    case EffectId::kGravityDisturbance:
      return "disturbances from a gravity model";
    case EffectId::kLidarRangeOffset:
    case EffectId::kLidarRangeScale:
      return "ranges to known targets; strips at two heights";
    case EffectId::kLidarAngleScale:
    case EffectId::kLidarScanCone:
    case EffectId::kLidarScanTorsion:
      return "the scanner's certificate; crossing strips";
    case EffectId::kBoresightDrift:
      return "a warm scanner; the first strip flown again at the end";
    case EffectId::kGyroScaleFactor:
    case EffectId::kGyroMisalignment:
    case EffectId::kGyroGSensitivity:
      return "the inertial unit's certificate; turns both ways";
    case EffectId::kAccelScaleFactor:
    case EffectId::kAccelMisalignment:
      return "the inertial unit's certificate; changes of speed";
    default:
      return "the data sheet";
  }
}

}  // namespace dn::diagnosis_internal
