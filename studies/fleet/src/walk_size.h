#pragma once

#include <dn/fleet/fleet.h>

#include "fleet_likelihood.h"

namespace dn::fleet_internal {

/// Estimates the size of a random walk of the boresight by restricted maximum likelihood, with an
/// upper limit (95 %, one-sided, by the likelihood ratio). The upper limit is infinite for two
/// flights that determine none.
BoresightWalk EstimateWalk(const FleetLikelihood& likelihood);

}  // namespace dn::fleet_internal
