#pragma once

#include <dn/builder/flight_network.h>

namespace dn {

/// Returns whether a surface of FlightNetwork::surfaces() is in use.
bool IsSurfaceInUse(const ControlNode& surface, const FlightNetwork& network);

/// Uses a surface of the network, or leaves it out: its returns are then not active, and its
/// position is held.
void UseSurface(const ControlNode& surface, bool use, FlightNetwork* network);

}  // namespace dn
