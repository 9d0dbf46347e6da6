#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/residual_form.h>

#include <vector>

namespace dn::diagnosis_internal {

/// Returns the forms that sum the residuals of an axis over time windows and over strip pairs.
std::vector<ResidualForm> CommonErrorForms(const FlightNetwork& network,
                                           const LinearizedNetwork& linearized);

}  // namespace dn::diagnosis_internal
