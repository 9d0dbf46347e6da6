#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/residual_form.h>

#include <vector>

namespace dn::internal {

/// Residuals of an axis summed over windows of time, and over pairs of strips.
std::vector<ResidualForm> CommonErrorForms(const FlightNetwork& network,
                                           const LinearizedNetwork& linearized);

}  // namespace dn::internal
