#pragma once

#include <dn/sim/simulate.h>

#include "testing/short_flights.h"

namespace dn::testing {

/// Returns the flight of DroneScenario with seed 7, simulated once.
inline const SimulatedFlight& DroneFlight() {
  static const SimulatedFlight sim = Fly(DroneScenario(), 7);
  return sim;
}

}  // namespace dn::testing
