#pragma once

#include <dn/builder/flight_network.h>

namespace dn::diagnosis_internal {

/// Builds the network of a flight that differs from the flight of `solved` only in its
/// configuration. The network is not solved. Its values are the trajectory, calibration and mean
/// biases of `solved`, and it uses the same pairs and GNSS epochs. One least-squares step suffices
/// if the solution hardly changes. `flight` must outlive the result. Throws as Build.
FlightNetwork BuildChangedNetwork(const FlightNetwork& solved, const Flight& flight, int threads);

}  // namespace dn::diagnosis_internal
