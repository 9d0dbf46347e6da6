#pragma once

#include <dn/builder/flight_network.h>

#include "screen.h"

namespace dn::internal {

/// A process as states of the network, at the time constants that are tried: the evidence by the
/// restricted likelihood of its sigma, exact where the cosines of the screen are cut short.
/// `solved`: the flight without the process, solved. A time constant whose network cannot be made is
/// left out; nothing is changed where none can.
void JudgeProcess(const FlightNetwork& solved, int threads, ScreenedEffect* effect);

/// Size and time constant of a process that was judged, at the maximum of the likelihood of both,
/// with standard deviations by its curvature in their logarithms; that of the time constant is no
/// number where the likelihood has no maximum near.
void RefineProcess(const FlightNetwork& solved, int threads, ScreenedEffect* effect);

}  // namespace dn::internal
