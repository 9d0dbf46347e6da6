#include "effects/physics.h"

namespace dn::effects {

void GravityTilt(const EffectInput& input, ActiveEffects* active) {
  const Eigen::Vector3d tilt_enu(input.value[1], input.value[0], 0.0);
  active->gravity_m.emplace_back([tilt_enu](const Eigen::Vector3d& p_m, const LocalFrame& frame) {
    return Eigen::Vector3d(frame.Gravity(p_m).norm() * (frame.R_m_enu(p_m) * tilt_enu));
  });
}

}  // namespace dn::effects
