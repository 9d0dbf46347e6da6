#include "effects/physics.h"

namespace dn::effects {

void LidarRangeScale(const EffectInput& input, ActiveEffects* active) {
  const double scale = input.value[0];
  active->laser_vector.emplace_back(
      [scale](const Eigen::Vector3d& u_s, double) { return Eigen::Vector3d((1.0 + scale) * u_s); });
}

void LidarRangeOffset(const EffectInput& input, ActiveEffects* active) {
  const double offset_m = input.value[0];
  active->laser_vector.emplace_back([offset_m](const Eigen::Vector3d& u_s, double) {
    return Eigen::Vector3d((1.0 + offset_m / u_s.norm()) * u_s);
  });
}

}  // namespace dn::effects
