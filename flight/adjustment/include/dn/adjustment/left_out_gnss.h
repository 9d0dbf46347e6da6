#pragma once

#include <dn/builder/flight_network.h>

namespace dn {

/// GNSS measurements of a network that are not in use: of one epoch the position, the velocity or
/// both.
struct LeftOutGnss {
  long positions = 0;
  long velocities = 0;
};

LeftOutGnss CountLeftOutGnss(const FlightNetwork& network);

}  // namespace dn
