#include <dn/files/scan_angle.h>

#include <cmath>

namespace dn {

double ScanAngle(const LidarConfig& lidar, const Eigen::Vector3d& u_s) {
  return std::atan2(u_s.dot(lidar.scan_axis_s.cross(lidar.nadir_axis_s)),
                    u_s.dot(lidar.nadir_axis_s));
}

}  // namespace dn
