#pragma once

#include <dn/builder/flight_network.h>

namespace dn {

/// Leaves out the GNSS epochs and pairs of a network that are left out in another network of the same
/// flight, or that the other does not have, as pairs both of whose epochs follow one of its nodes.
void KeepInUse(const FlightNetwork& other, FlightNetwork* network);

}  // namespace dn
