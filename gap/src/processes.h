#pragma once

#include <dn/builder/flight_network.h>

#include "screen.h"

namespace dn::internal {

/// A process as states of the network, at the time constants that are tried: the evidence by the
/// restricted likelihood of its sigma, exact where the cosines of the screen are cut short.
/// `solved`: the flight without the process, solved. A time constant whose network cannot be made is
/// left out; nothing is changed where none can.
void JudgeProcess(const FlightNetwork& solved, int threads, ScreenedEffect* effect);

}  // namespace dn::internal
