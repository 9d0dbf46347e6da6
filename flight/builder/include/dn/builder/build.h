#pragma once

#include <dn/builder/flight_network.h>
#include <dn/flight/flight.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// Where a network stands: poses and calibration of any source, a plan, a truth or a solution.
struct NetworkDesign {
  /// By time, at least two, with velocities; in between InterpolatePose.
  std::vector<MapPose> poses;
  std::vector<double> node_t_s = {};                 ///< empty: FlightNodeTimes over NetworkSpan
  std::optional<CalibrationState> calibration = {};  ///< absent: AssumedCalibration of the flight
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
};

/// The whole network of a flight at a design, pairs included, unsolved: its marginals are the
/// covariances that the flight would give. They need no measured values; of a flight that has none,
/// PlanMeasurements first.
///
///   dn::Flight plan = ...;                       // config, frame, and pairs with laser vectors
///   dn::PlanMeasurements({poses}, {}, &plan);
///   const dn::FlightNetwork network = dn::Build(plan, {poses});
///   const Eigen::Matrix3d covariance = dn::MarginalCovariance(network.net, network.boresight);
///
/// The flight must outlive the network. Throws InvalidInput where the flight has no inertial data,
/// the poses do not cover the nodes, or as the FlightNetwork.
FlightNetwork Build(const Flight& flight, const NetworkDesign& design,
                    const FlightNetworkOptions& options = {});

/// The rates at which the sensors of a plan will measure.
struct PlannedRates {
  double imu_hz = 100.0;
  double gnss_hz = 1.0;
};

/// Gives a flight the inertial and GNSS data that it has not: what perfect sensors would measure on
/// the design's poses (ImpliedImu; the antenna at its lever arm, without a covariance of its own,
/// so that gnss.sigma_enu_m of the configuration holds). Effects are at zero. What the flight has
/// already stays. Throws InvalidInput where the poses are too few for a sample or an epoch.
void PlanMeasurements(const NetworkDesign& design, const PlannedRates& rates, Flight* flight);

}  // namespace dn
