#pragma once

#include <dn/builder/flight_network.h>
#include <dn/diagnosis/model_check.h>
#include <dn/solvers/marginals.h>

#include <vector>

#include "hypothesis.h"
#include "unmodelled.h"

namespace dn::diagnosis_internal {

/// Returns the changes of all nodes by the unmodelled effects of a library, in their order.
std::vector<NodeChange> NodeChanges(const FlightNetwork& network, const Marginals& marginals,
                                    const Library& library, const UnmodelledUnknowns& unmodelled);

}  // namespace dn::diagnosis_internal
