#include "effects/physics.h"

namespace dn::effects {

void GnssLeverArm(const EffectInput& input, ActiveEffects* active) {
  active->gnss_lever_arm_b_m += input.value;
}

void LidarLeverArm(const EffectInput& input, ActiveEffects* active) {
  active->lidar_lever_arm_b_m += input.value;
}

}  // namespace dn::effects
