#include <dn/rotation.h>

#include "effects/physics.h"

namespace dn::effects {

void TrajectoryAttitudeOffset(const EffectInput& input, ActiveEffects* active) {
  active->trajectory_turn.push_back(Exp(Eigen::Vector3d(input.value)));
}

}  // namespace dn::effects
