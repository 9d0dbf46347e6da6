#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace dn {

/// State of the forward filter: the pose and the value of every process.
///
/// Covariance order: attitude (right, rad), position (m), velocity (m/s), gyro processes (3 each),
/// then accelerometer processes, then processes of GNSS errors.
struct FilterState {
  MapPose pose;
  std::vector<Eigen::Vector3d> gyro_bias;   ///< per process, rad/s
  std::vector<Eigen::Vector3d> accel_bias;  ///< per process, m/s^2
  /// One value per process of GNSS errors, in units of its sigmas (see CorrelatedGnssError).
  std::vector<Eigen::Vector3d> gnss_error;
  Eigen::MatrixXd covariance;

  Eigen::Vector3d TotalGyroBias() const;
  Eigen::Vector3d TotalAccelBias() const;
};

/// The innovation of one measurement: the measured value minus the value predicted from all earlier
/// measurements.
struct Innovation {
  double t_s = 0.0;
  bool velocity = false;       ///< true for a velocity, false for a position
  Eigen::Vector3d normalised;  ///< per axis east, north, up: innovation / its predicted sigma
  double nis = 0.0;            ///< normalised innovation squared of the three axes together
};

/// The end of a filter run and the measurements and weights that it uses.
struct FilterOptions {
  double t_end_s = 1e300;  ///< time at which the filter stops
  /// Bound of the innovations in sigmas (root of NIS); 0: no bound. The weight of a larger
  /// innovation is reduced so that its influence is that of an innovation at the bound.
  double huber_sigmas = 0.0;
  /// Added in quadrature to the sigmas of the measurements. As long as the attitude error is
  /// several degrees, the linearisation error of the filter exceeds the noise of a good receiver.
  double position_floor_m = 0.0;
  double velocity_floor_mps = 0.0;
  /// Epochs that are not used: ascending indices into Flight::gnss.
  std::vector<std::size_t> skipped_epochs;
  /// Polled at every time; if it returns true, Interrupted is thrown.
  std::function<bool()> interrupted = {};
  std::optional<CalibrationState> calibration = {};  ///< absent: AssumedCalibration of the flight
};

/// The states and innovations of a filtered flight.
struct FilterRun {
  /// One state per requested time, after the update with its measurements; the covariance is empty.
  std::vector<FilterState> states;
  std::vector<Innovation> innovations;
  double log_likelihood = 0.0;  ///< up to a constant common to all initial states
  FilterState last;             ///< the last state, with its covariance
};

/// Runs an extended Kalman filter with the same factors as the network. The prediction uses the
/// preintegrated inertial edge, whose Jacobians give transition matrix and process noise. The
/// update uses the GNSS position and velocity edges. The filter gives the initial values of the
/// network and the innovations for tests.
///
/// times: sorted; must contain every GNSS epoch to be used. The first one is start.pose.t_s.
FilterRun RunForwardFilter(const Flight& flight, const std::vector<double>& times,
                           const FilterState& start, const FilterOptions& options = {});

/// Returns the filter state at a pose. The processes have the prior covariance of the IMU and GNSS
/// models. Attitude (rad, about body x, y, z), position and velocity have the given sigmas.
FilterState MakeFilterState(const Flight& flight, const MapPose& pose,
                            const Eigen::Vector3d& gyro_bias_radps,
                            const Eigen::Vector3d& accel_bias_mps2,
                            const Eigen::Vector3d& sigma_attitude_rad, double sigma_position_m,
                            double sigma_velocity_mps);

}  // namespace dn
