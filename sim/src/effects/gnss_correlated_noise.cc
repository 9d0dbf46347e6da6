#include "antenna_error.h"
#include "effects/physics.h"

namespace dn::effects {

void GnssCorrelatedNoise(const EffectInput& input, ActiveEffects* active) {
  active->antenna_enu_m.emplace_back(
      AntennaError({input.value.head<3>(), input.value[3]}, input.MakeRandom()));
}

}  // namespace dn::effects
