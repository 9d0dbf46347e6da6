#include <cmath>

#include "effects/physics.h"

namespace dn::effects {

void LidarAngleScale(const EffectInput& input, ActiveEffects* active) {
  const double scale = input.value[0];
  const Eigen::Vector3d axis_s = input.scenario.lidar.scan_axis_s.normalized();
  const Eigen::Vector3d nadir_s = input.scenario.lidar.nadir_axis_s;
  active->laser_vector.emplace_back([scale, axis_s, nadir_s](const Eigen::Vector3d& u_s, double) {
    const double angle = std::atan2(u_s.dot(axis_s.cross(nadir_s)), u_s.dot(nadir_s));
    return Eigen::Vector3d(Eigen::AngleAxisd(scale * angle, axis_s) * u_s);
  });
}

}  // namespace dn::effects
