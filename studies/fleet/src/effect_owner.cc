#include "effect_owner.h"

namespace dn::fleet_internal {

EffectOwner FindOwner(EffectId effect) {
  switch (effect) {
    case EffectId::kGnssLeverArm:
    case EffectId::kGyroScaleFactor:
    case EffectId::kAccelScaleFactor:
    case EffectId::kGyroMisalignment:
    case EffectId::kAccelMisalignment:
    case EffectId::kGyroGSensitivity:
    case EffectId::kLidarLeverArm:
    case EffectId::kLidarRangeOffset:
    case EffectId::kLidarRangeScale:
    case EffectId::kLidarAngleScale:
    case EffectId::kLidarScanCone:
    case EffectId::kLidarScanTorsion:
      return EffectOwner::kSensor;
    case EffectId::kGravityTilt:
    case EffectId::kGravityDisturbance:
      return EffectOwner::kPlace;
    default:
      return EffectOwner::kDay;
  }
}

}  // namespace dn::fleet_internal
