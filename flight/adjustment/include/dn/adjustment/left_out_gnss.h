#pragma once

#include <dn/builder/flight_network.h>

namespace dn {

/// Numbers of GNSS measurements of a network that are not active. An epoch can have its position,
/// its velocity or both left out.
struct LeftOutGnss {
  long positions = 0;
  long velocities = 0;
};

LeftOutGnss CountLeftOutGnss(const FlightNetwork& network);

}  // namespace dn
