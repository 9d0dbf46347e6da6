#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/residual_form.h>

#include <vector>

namespace dn::diagnosis_internal {

/// Returns forms that sum the residuals of an axis over the pairs of two strips within a square
/// tile of the ground: one form per edge length of the tiles, m. Empty if a user's factor replaces
/// all pair factors and gives no points.
std::vector<ResidualForm> PairClusters(const FlightNetwork& network,
                                       const LinearizedNetwork& linearized,
                                       const std::vector<double>& lengths_m);

}  // namespace dn::diagnosis_internal
