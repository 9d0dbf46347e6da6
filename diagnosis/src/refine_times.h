#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include "hypothesis_evidence.h"

namespace dn::diagnosis_internal {

/// Refines the window of a gnss_position_step, or the start of a boresight_step, to a fraction of
/// the screen's cells. Updates times, estimate, sigma and the shift of the boresight. Leaves any
/// other effect unchanged.
void RefineTimes(const FlightNetwork& network, const Marginals& marginals, int threads,
                 HypothesisEvidence* effect);

}  // namespace dn::diagnosis_internal
