#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Correlation of the boresight (rows roll, pitch, yaw) with the total biases at t_s (columns x, y,
/// z). The total bias of an axis is the sum of its processes; the correlation is zero without
/// processes.
struct BiasCorrelationAt {
  double t_s = 0.0;
  Eigen::Matrix3d gyro = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d accel = Eigen::Matrix3d::Zero();
};

/// Returns the correlations at every node. `marginals` must have its selected inverse; `boresight`
/// are the columns of the boresight in the covariance matrix.
std::vector<BiasCorrelationAt> BiasCorrelationOverTime(const FlightNetwork& network,
                                                       const Marginals& marginals,
                                                       const Marginals::Columns& boresight,
                                                       std::size_t scanner = 0);

/// Returns the mean epoch of the active pairs, s; the epoch of the first node if there are none.
double LidarBarycentre(const FlightNetwork& network);

}  // namespace dn
