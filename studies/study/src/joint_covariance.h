#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// One number among the constants of a flight.
struct JointUnknown {
  std::string name;  ///< "boresight_roll", "gnss_lever_arm_x", "accel_bias_y"
  std::string unit;
  double per_si = 1.0;
  bool calibration = false;  ///< else an error that lasts, at the barycentre of the pairs
};

/// The covariance of all calibration unknowns, and of the lasting errors with them, SI. The boresight
/// comes first, then the others in the order of `estimate`.
struct JointCovariance {
  std::vector<JointUnknown> unknowns;
  Eigen::MatrixXd covariance;

  double sigma(Eigen::Index i) const;
  double correlation(Eigen::Index i, Eigen::Index j) const;
};

/// The free calibration unknowns alone.
JointCovariance CalibrationCovariance(const FlightNetwork& network, const Marginals& marginals);

/// With the total gyro and accelerometer biases and the total error of the GNSS positions at the
/// barycentre of the pairs.
JointCovariance CovarianceWithErrors(const FlightNetwork& network, const Marginals& marginals);

}  // namespace dn
