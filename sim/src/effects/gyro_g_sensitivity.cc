#include "effects/physics.h"

namespace dn::effects {

void GyroGSensitivity(const EffectInput& input, ActiveEffects* active) {
  const Eigen::Vector3d per_force = input.value;
  active->triads.emplace_back([per_force](const ImuSample& truth, ImuSample* sample) {
    sample->w_ib_b_radps += per_force.cwiseProduct(truth.f_b_mps2);
  });
}

}  // namespace dn::effects
