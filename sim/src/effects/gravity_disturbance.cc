#include "effects/physics.h"

namespace dn::effects {

void GravityDisturbance(const EffectInput& input, ActiveEffects* active) {
  const double more_mps2 = input.value[0];
  active->gravity_m.emplace_back([more_mps2](const Eigen::Vector3d& p_m, const LocalFrame& frame) {
    return Eigen::Vector3d(more_mps2 * frame.Gravity(p_m).normalized());
  });
}

}  // namespace dn::effects
