#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/flight/flight.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace dn {

/// State of the forward filter: pose, and the value of every process.
///
/// Covariance order: attitude (right, rad), position (m), velocity (m/s), gyro processes (3 each),
/// then accelerometer processes, then processes of GNSS errors.
struct FilterState {
  MapPose pose;
  std::vector<Eigen::Vector3d> gyro_bias;   ///< per process, rad/s
  std::vector<Eigen::Vector3d> accel_bias;  ///< per process, m/s^2
  std::vector<Eigen::Vector3d> gnss_error;  ///< per process, in its sigmas, see GnssError
  Eigen::MatrixXd covariance;

  Eigen::Vector3d TotalGyroBias() const;
  Eigen::Vector3d TotalAccelBias() const;
};

/// One measurement's innovation (measured against predicted from all earlier measurements).
struct Innovation {
  double t_s = 0.0;
  bool velocity = false;       ///< false: position
  Eigen::Vector3d normalised;  ///< per axis east, north, up: innovation / its predicted sigma
  double nis = 0.0;            ///< normalised innovation squared of the three axes together
};

/// How far the filter runs and what it uses.
struct FilterOptions {
  double t_end_s = 1e300;  ///< stop after this epoch
  /// Innovations beyond this many sigmas (root of NIS) are de-weighted so that they pull no more
  /// than one at the bound; 0: never.
  double huber_sigmas = 0.0;
  /// Added in quadrature to the sigmas of the measurements: while the attitude is still degrees
  /// off, the linearisation of the filter errs by more than a good receiver does.
  double position_floor_m = 0.0;
  double velocity_floor_mps = 0.0;
  std::vector<std::size_t> skipped_epochs;  ///< not used; indices into Flight::gnss, rising
  std::function<bool()> interrupted = {};   ///< polled at every time; true throws Interrupted
  std::optional<CalibrationState> calibration = {};  ///< absent: AssumedCalibration of the flight
};

/// The states and innovations of a filtered flight.
struct FilterRun {
  std::vector<FilterState>
      states;  ///< one per requested time, after its measurements; covariance left empty
  std::vector<Innovation> innovations;
  double log_likelihood = 0.0;  ///< up to a constant that is common to all starts
  FilterState last;             ///< with covariance
};

/// Extended Kalman filter over the very factors of the network: prediction by the preintegrated
/// inertial edge (its Jacobians give transition and process noise), update by the GNSS position and
/// velocity edges. Used to start the network and to test innovations.
///
/// times: sorted; must contain every GNSS epoch that is to be used; start.pose.t_s is the first.
FilterRun RunForwardFilter(const Flight& flight, const std::vector<double>& times,
                           const FilterState& start, const FilterOptions& options = {});

/// Filter state at a pose with the model's own prior covariance on the processes and the given
/// standard deviations of attitude (rad, about body x, y, z), position and velocity.
FilterState MakeFilterState(const Flight& flight, const MapPose& pose,
                            const Eigen::Vector3d& gyro_bias_radps,
                            const Eigen::Vector3d& accel_bias_mps2,
                            const Eigen::Vector3d& sigma_attitude_rad, double sigma_position_m,
                            double sigma_velocity_mps);

}  // namespace dn
