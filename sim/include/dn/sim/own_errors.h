#pragma once

#include <dn/geo/trajectory.h>
#include <dn/lidar/pairs.h>

#include <Eigen/Core>
#include <functional>

namespace dn {

/// Errors of a flight that no entry of `effects:` describes. They are functions of the caller,
/// which the simulation calls when it computes the quantity, also without noise. An empty function
/// changes nothing.
struct OwnErrors {
  /// Error added to the angular rate of the inertial sample at this time, body axes, rad/s.
  std::function<Eigen::Vector3d(double t_s)> gyro_radps = {};
  /// Error added to the specific force of the inertial sample at this time, body axes, m/s^2.
  std::function<Eigen::Vector3d(double t_s)> specific_force_mps2 = {};
  /// Error added to the antenna position, east, north, up, m.
  std::function<Eigen::Vector3d(double t_s)> antenna_enu_m = {};
  /// Error added to the rotation vector of the boresight at a pose of the flight, rad.
  std::function<Eigen::Vector3d(const MapPose& pose)> boresight_rad = {};
  /// Measured laser vector for a true one in the sensor frame, at the true time t_s.
  std::function<Eigen::Vector3d(const Eigen::Vector3d& u_s, double t_s)> laser_vector = {};
  /// Error added to the time tags of the pairs, s; t_s is the true time.
  std::function<double(double t_s)> lidar_tag_shift_s = {};
  /// Function that changes the finished pairs.
  std::function<void(PairData* pairs)> pairs = {};
};

}  // namespace dn
