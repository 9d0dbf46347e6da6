#pragma once

#include <dn/builder/flight_network.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// The linearisation point of a network: poses and calibration from a plan, from the truth or from
/// a solution.
struct NetworkDesign {
  /// Sorted by time, at least two, with velocities; InterpolatePose gives the pose between two of
  /// them.
  std::vector<MapPose> poses;
  std::vector<double> node_t_s = {};  ///< node times; empty: FlightNodeTimes over NetworkSpan
  std::optional<CalibrationState> calibration = {};  ///< absent: AssumedCalibration of the flight
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
};

/// Returns the whole unsolved network of a flight at a design, point pairs included. Its marginal
/// covariances are those that the flight would give. They do not depend on measured values. For a
/// flight without measurements, call PlanMeasurements first.
///
///   dn::Flight plan = ...;                       // config, frame, and pairs with laser vectors
///   dn::PlanMeasurements({poses}, {}, &plan);
///   const dn::FlightNetwork network = dn::Build(plan, {poses});
///   const Eigen::Matrix3d covariance =
///       dn::MarginalCovariance(network.net(), network.calibration().boresight());
///
/// The flight must outlive the network, so a temporary flight does not compile. Throws InvalidInput
/// if the flight has no inertial data or the poses do not cover the nodes, and like the constructor
/// of FlightNetwork.
FlightNetwork Build(const Flight& flight, const NetworkDesign& design,
                    const FlightNetworkOptions& options = {});
FlightNetwork Build(const Flight&& flight, const NetworkDesign& design,
                    const FlightNetworkOptions& options = {}) = delete;

/// The measurement rates of the planned sensors.
struct PlannedRates {
  double imu_hz = 100.0;
  double gnss_hz = 1.0;
};

/// Adds the inertial and GNSS data that a flight lacks: the readings of perfect sensors on the
/// poses of the design. The inertial data come from ImpliedImu. The GNSS epochs are antenna
/// positions without a covariance of their own, so that gnss.sigma_enu_m of the configuration
/// applies. All effects are zero. Existing data of the flight remain unchanged. Throws InvalidInput
/// if the poses are too short for one sample or one epoch.
void PlanMeasurements(const NetworkDesign& design, const PlannedRates& rates, Flight* flight);

}  // namespace dn
