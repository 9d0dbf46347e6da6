#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace dn {

/// Axes of a scanner, unit vectors in its frame.
struct ScanAxes {
  explicit ScanAxes(const Scenario& scenario)
      : axis_s(scenario.lidar.scan_axis_s.normalized()),
        nadir_s(scenario.lidar.nadir_axis_s.normalized()) {}

  /// Rotation of a laser vector about the scan axis, from nadir, rad.
  double Angle(const Eigen::Vector3d& u_s) const {
    return std::atan2(u_s.dot(axis_s.cross(nadir_s)), u_s.dot(nadir_s));
  }

  Eigen::Vector3d axis_s, nadir_s;
};

}  // namespace dn
