#pragma once

#include <dn/flight/flight_config.h>

#include <Eigen/Core>

namespace dn {

/// Scan angle of a laser vector in the sensor frame, rad: atan2(u . (scan_axis x nadir_axis),
/// u . nadir_axis), by projection where the beam leaves the scan plane.
double ScanAngle(const LidarConfig& lidar, const Eigen::Vector3d& u_s);

}  // namespace dn
