#pragma once

#include <dn/builder/flight_network.h>
#include <dn/sim/simulate.h>

#include <memory>
#include <string>

namespace dn::bench {

/// A simulated flight and its network at the truth.
struct FlightAtTruth {
  SimulatedFlight simulated;
  std::unique_ptr<FlightNetwork> network;  ///< refers to the flight
};

/// Simulates the flight of a size (FlightSizes) with a navigation-grade sensor, and makes its
/// network with `rate_hz` nodes per second in the strips.
std::unique_ptr<FlightAtTruth> MakeFlightAtTruth(const std::string& size, double rate_hz);

}  // namespace dn::bench
