#pragma once

#include <dn/files/flight.h>
#include <dn/sim/simulate.h>

#include <string>

#include "testing/short_flights.h"

namespace dn::testing {

/// Returns a flight of DroneScenario with these effects and the default seed.
inline Flight SimulateDrone(const std::string& effects = "") {
  return Simulate(DroneScenario(effects), {}).flight;
}

}  // namespace dn::testing
