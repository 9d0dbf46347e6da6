#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>

namespace dn {

/// Returns the derivative of the whitened residuals of a GNSS position by a shift of the antenna,
/// map axes, 1/m, 3 x 3. The position may be in use or not.
inline Eigen::MatrixXd AntennaDerivative(const FlightNetwork& network,
                                         const LinearizedNetwork& linearized,
                                         const GnssEdge& edge) {
  // The antenna moves as the position of the body does.
  const BlockId p_mb = network.nodes()[edge.node].p_mb.id;
  for (const auto& [block, J] : linearized.EvaluateFactorAt(edge.position).jacobian) {
    if (block == p_mb) return J;
  }
  return Eigen::MatrixXd::Zero(3, 3);
}

}  // namespace dn
