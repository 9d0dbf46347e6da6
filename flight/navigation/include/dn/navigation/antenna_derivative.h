#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>

namespace dn {

/// Returns the derivative of the whitened residuals of a GNSS position by a shift of the antenna,
/// map axes, 1/m, 3 x 3. `position` is the evaluated factor of the edge's position.
inline Eigen::MatrixXd AntennaDerivative(const FlightNetwork& network, const GnssEdge& edge,
                                         const LinearizedNetwork::Factor& position) {
  // The antenna moves as the position of the body does.
  const BlockId p_mb = network.nodes()[edge.node].p_mb.id;
  for (const auto& [block, J] : position.jacobian) {
    if (block == p_mb) return J;
  }
  return Eigen::MatrixXd::Zero(3, 3);
}

}  // namespace dn
