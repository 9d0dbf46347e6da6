#include "effects/physics.h"

namespace dn::effects {

void BoresightStep(const EffectInput& input, ActiveEffects* active) {
  const Eigen::Vector3d step_rad = input.value;
  const EffectTimes times = input.entry.times;
  active->boresight_rad.emplace_back([step_rad, times](double t_s, const LidarSpan&) {
    return times.During(t_s) ? step_rad : Eigen::Vector3d::Zero().eval();
  });
}

}  // namespace dn::effects
