#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include "screen.h"

namespace dn::internal {

/// The window of a gnss_position_step or the start of a boresight_step to a fraction of the cells
/// of the screen, with the effect's values and evidence there; any other effect is left as it is.
void RefineTimes(const FlightNetwork& network, const Marginals& marginals, int threads,
                 ScreenedEffect* effect);

}  // namespace dn::internal
