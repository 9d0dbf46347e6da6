#include "antenna_error.h"
#include "effects/physics.h"

namespace dn::effects {

void GnssMultipath(const EffectInput& input, ActiveEffects* active) {
  active->antenna_enu_m.emplace_back(AntennaError(
      {input.value.head<3>(), input.value[3], GnssErrorGrowth::kBank}, input.MakeRandom()));
}

}  // namespace dn::effects
