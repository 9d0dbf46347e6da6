#pragma once

#include <dn/error.h>

#include <Eigen/Core>

namespace dn::lidar_internal {

/// Throws InvalidInput at `where` unless the laser vector is between 1 mm and 50 km long.
void CheckLaserVector(const Eigen::Vector3d& u_m, const FileLocation& where);

}  // namespace dn::lidar_internal
