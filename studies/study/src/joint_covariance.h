#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// A number among the constants of a flight.
struct JointUnknown {
  std::string name;  ///< "boresight_roll", "gnss_lever_arm_x", "accel_bias_y"
  std::string unit;
  double per_si = 1.0;
  bool calibration = false;  ///< else a time-correlated error, at the barycentre of the pairs
};

/// The joint covariance of all calibration unknowns and time-correlated errors, SI. The boresight
/// comes first, then the others in the order of `estimate`.
struct JointCovariance {
  std::vector<JointUnknown> unknowns;
  Eigen::MatrixXd covariance;

  double sigma(Eigen::Index i) const;
  double correlation(Eigen::Index i, Eigen::Index j) const;
};

/// Returns the covariance of the free calibration unknowns alone.
JointCovariance CalibrationCovariance(const FlightNetwork& network, const Marginals& marginals);

/// Returns the covariance with the total gyro and accelerometer biases, and the total error of the
/// GNSS positions, at the barycentre of the pairs.
JointCovariance CovarianceWithErrors(const FlightNetwork& network, const Marginals& marginals);

}  // namespace dn
