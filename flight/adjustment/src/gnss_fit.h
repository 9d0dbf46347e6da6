#pragma once

#include <dn/builder/flight_network.h>

namespace dn::internal {

/// Whether more than half of the GNSS positions in use lie further off than noise, time-correlated
/// errors and outliers could make it: their median residual exceeds 30 sigmas. Wrong axes, units
/// and coordinates leave hundreds.
bool IsHopeless(const FlightNetwork& network);

/// Whether a step of the clock that took the cost from `before` to `after` is worth another one:
/// the network is not hopeless, or the cost has halved, as it does many times where a clock is the
/// cause.
bool ClockMayExplain(const FlightNetwork& network, double before, double after);

}  // namespace dn::internal
