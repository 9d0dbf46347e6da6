#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>
#include <vector>

namespace dn::navigation_internal {

/// An active position with the derivative of its residuals with respect to an error along east,
/// north, up.
struct PositionInUse {
  double t_s;
  int first_row;
  Eigen::Matrix3d L;  // d residual / d error (east, north, up)
};

std::vector<PositionInUse> PositionsInUse(const FlightNetwork& network,
                                          const LinearizedNetwork& linearized);

/// Returns the median interval between positions, s.
double MedianInterval(const std::vector<PositionInUse>& positions);

}  // namespace dn::navigation_internal
