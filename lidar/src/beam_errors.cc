#include <dn/error.h>
#include <dn/lidar/beam_errors.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

namespace dn {

Eigen::Vector3d BeamErrors::Remove(const Eigen::Vector3d& u_s, int beam) const {
  const auto k = static_cast<std::size_t>(beam);
  if (beam < 0 || k >= std::max(angle_rad.size(), range_m.size())) {
    throw InvalidInput(
        "beam " + std::to_string(beam) + " does not exist: there are corrections of " +
        std::to_string(std::max(angle_rad.size(), range_m.size())) + " beams, numbered from 0");
  }
  Eigen::Vector3d u = u_s;
  const Eigen::Vector3d turn = u.cross(scan_axis_s);
  if (!angle_rad.empty() && turn.norm() > 0.0) {
    u = Eigen::AngleAxisd(angle_rad[k], turn.normalized()) * u;
  }
  if (!range_m.empty()) u *= 1.0 - range_m[k] / u.norm();
  return u;
}

}  // namespace dn
