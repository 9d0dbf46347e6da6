#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Correlation of the boresight (rows roll, pitch, yaw) with the total biases (sum of the processes
/// of an axis, columns x, y, z) that hold at t_s; zero without processes.
struct BiasCorrelationAt {
  double t_s = 0.0;
  Eigen::Matrix3d gyro = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d accel = Eigen::Matrix3d::Zero();
};

/// At every node. `marginals` must have its selected inverse; boresight are the columns of the
/// boresight.
std::vector<BiasCorrelationAt> BiasCorrelationOverTime(const FlightNetwork& network,
                                                       const Marginals& marginals,
                                                       const Marginals::Columns& boresight);

/// Mean epoch of the pairs in use, s; that of the first node without any.
double LidarBarycentre(const FlightNetwork& network);

}  // namespace dn
