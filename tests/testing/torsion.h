#pragma once

#include <dn/geo/local_frame.h>
#include <dn/sim/simulate.h>

#include <Eigen/Core>
#include <cmath>

namespace dn::testing {

/// Simulates a mirror whose beam leaves its scan plane by a sine of eight times the scan angle. The
/// torsion of the effect table has a sine of four times the angle.
inline SimulatedFlight FlyWithTorsion(const Scenario& scenario, double amplitude_deg) {
  const Eigen::Vector3d axis_s = scenario.lidar.scan_axis_s.normalized();
  const Eigen::Vector3d nadir_s = scenario.lidar.nadir_axis_s.normalized();
  SimulateOptions options;
  options.seed = 3;
  options.own.laser_vector = [=](const Eigen::Vector3d& u_s, double) {
    const double angle = std::atan2(u_s.dot(axis_s.cross(nadir_s)), u_s.dot(nadir_s));
    const double forward_rad = kRadPerDeg * amplitude_deg * std::sin(8.0 * angle + 0.4);
    return Eigen::Vector3d(u_s + u_s.norm() * forward_rad * axis_s);
  };
  return Simulate(scenario, options);
}

}  // namespace dn::testing
