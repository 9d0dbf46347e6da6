#pragma once

#include <dn/effects/effect_table.h>

namespace dn::fleet_internal {

/// The cause of an effect, which decides which flights share its value.
enum class EffectOwner {
  kSensor,  ///< mechanics and electronics of the sensors: constant over all flights
  kPlace,   ///< gravity: the same for all flights at a place
  kDay,     ///< clocks, temperature, satellites: another value in each flight
};

EffectOwner FindOwner(EffectId effect);

}  // namespace dn::fleet_internal
