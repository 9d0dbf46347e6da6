#include "effects/physics.h"

namespace dn::effects {

void GnssPositionStep(const EffectInput& input, ActiveEffects* active) {
  const Eigen::Vector3d step_enu_m = input.value;
  const EffectTimes times = input.entry.times;
  active->antenna_enu_m.emplace_back([step_enu_m, times](double t_s, double) {
    return times.During(t_s) ? step_enu_m : Eigen::Vector3d::Zero().eval();
  });
}

}  // namespace dn::effects
