#pragma once

#include <dn/files/flight_config.h>

#include <Eigen/Core>

namespace dn {

/// Returns the scan angle of a laser vector in the scanner frame, rad: atan2(u . (scan_axis x
/// nadir_axis), u . nadir_axis). A beam outside of the scan plane is projected onto it.
double ScanAngle(const LidarConfig& lidar, const Eigen::Vector3d& u_s);

}  // namespace dn
