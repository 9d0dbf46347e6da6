#include "effects/physics.h"

namespace dn::effects {

void BoresightDrift(const EffectInput& input, ActiveEffects* active) {
  const Eigen::Vector3d rate_radps = input.value;
  active->boresight_rad.emplace_back([rate_radps](double t_s, const LidarSpan& span) {
    return Eigen::Vector3d(rate_radps * (t_s - span.middle_s()));
  });
}

}  // namespace dn::effects
