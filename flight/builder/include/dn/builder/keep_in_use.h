#pragma once

#include <dn/builder/flight_network.h>

namespace dn {

/// Deactivates the GNSS epochs and pairs of a network that are inactive or missing in another
/// network of the same flight. A pair is missing there if both of its epochs follow the same node.
void KeepInUse(const FlightNetwork& other, FlightNetwork* network);

}  // namespace dn
