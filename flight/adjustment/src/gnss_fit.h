#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/solve.h>

namespace dn::adjustment_internal {

/// A cause of a misfit must remove this share of it.
inline constexpr double kExplainedShare = 0.5;

/// Returns the excess of the sum of squared residuals over its expectation.
double Excess(const CostSummary& cost);

/// Returns whether the median residual of the GNSS positions in use exceeds 30 sigmas. Neither
/// noise, time-correlated errors nor outliers can cause this. Wrong axes, units or coordinates
/// leave residuals of hundreds of sigmas.
bool IsHopeless(const FlightNetwork& network);

/// Returns whether another step of the clock is worthwhile after a step that changed the cost from
/// `before` to `after`. It is if the network is not hopeless, or if the cost has at least halved.
/// If the clock is the cause, the cost halves many times.
bool ClockMayExplain(const FlightNetwork& network, double before, double after);

}  // namespace dn::adjustment_internal
