#pragma once

#include <dn/builder/flight_network.h>
#include <dn/imu/preintegration.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>
#include <vector>

namespace dn::diagnosis_internal {

/// Returns, for every row of the network, the variance that this noise of the inertial sensors
/// gives it, in units of its stated variance. Rows of other sensors have 0. Correlations between
/// the rows of an increment are neglected; the rotation rows have none.
Eigen::VectorXd InertialShare(const FlightNetwork& network, const LinearizedNetwork& linearized,
                              const PreintegrationNoise& noise);

/// Evidence of the residuals of a network for a noise that the raw inertial data show.
struct NetworkSupport {
  double log_evidence = 0.0;  ///< nats, relative to the stated noise
  double theta = 0.0;         ///< most probable relative growth of the variance
  bool of_raw_data = false;   ///< theta is that of the raw data
};

/// Raw inertial data contain the motion of a shaking platform; only errors of the increments reach
/// the result. The evidence of a noise is therefore the restricted likelihood of the residuals with
/// the variances 1 + theta share. The sizes are ascending, and the last one is that of the raw
/// data. It is chosen unless another size is far more probable.
NetworkSupport FindNetworkSupport(const LinearizedNetwork& linearized, const Eigen::VectorXd& share,
                                  const std::vector<double>& thetas, int threads);

}  // namespace dn::diagnosis_internal
