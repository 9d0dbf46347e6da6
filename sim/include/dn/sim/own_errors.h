#pragma once

#include <dn/geo/trajectory.h>
#include <dn/lidar/pairs.h>

#include <Eigen/Core>
#include <functional>

namespace dn {

/// Errors of a flight that no entry of `effects:` describes: functions of the caller, each called
/// where the simulation makes the quantity, also without noise. An empty one changes nothing.
struct OwnErrors {
  /// Added to the angular rate of the inertial sample with this time, body axes, rad/s.
  std::function<Eigen::Vector3d(double t_s)> gyro_radps = {};
  /// Added to the antenna position, east, north, up, m.
  std::function<Eigen::Vector3d(double t_s)> antenna_enu_m = {};
  /// Added to the boresight's rotation vector at a pose of the flight, rad.
  std::function<Eigen::Vector3d(const MapPose& pose)> boresight_rad = {};
  /// What the scanner makes, at the true time t_s, of the vector to a point in its frame.
  std::function<Eigen::Vector3d(const Eigen::Vector3d& u_s, double t_s)> laser_vector = {};
  /// Added to the time tags of the pairs, s; t_s is the true time.
  std::function<double(double t_s)> lidar_tag_shift_s = {};
  /// What becomes of the finished pairs.
  std::function<void(PairData* pairs)> pairs = {};
};

}  // namespace dn
