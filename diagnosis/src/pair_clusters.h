#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/residual_form.h>

#include <vector>

namespace dn::diagnosis_internal {

/// Returns forms that sum the residuals of one axis over the pairs of two strips within a square
/// tile of the ground. There is one form per axis and edge length of the tiles, m, with all lengths
/// of an axis together. ResidualForm::channel is that of the axis, for example "lidar p2p up".
/// Empty if a user's factor replaces all pair factors and gives no points.
std::vector<ResidualForm> PairClusters(const FlightNetwork& network,
                                       const LinearizedNetwork& linearized,
                                       const std::vector<double>& lengths_m);

}  // namespace dn::diagnosis_internal
