#pragma once

#include <dn/builder/flight_network.h>

namespace dn {

/// Activates exactly the GNSS epochs, pairs and control points of a network that are active in
/// another network of the same flight. A GNSS epoch that the other network lacks stays as it is: no
/// node was near it there. A pair or control point that it lacks is deactivated; a pair is missing
/// if both of its epochs follow the same node.
void KeepInUse(const FlightNetwork& other, FlightNetwork* network);

}  // namespace dn
