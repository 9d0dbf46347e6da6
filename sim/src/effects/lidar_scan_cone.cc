#include "effects/physics.h"

namespace dn::effects {

void LidarScanCone(const EffectInput& input, ActiveEffects* active) {
  if (input.value[0] == 0.0) return;  // else the last digits would go, too
  active->scan_cone_rad += input.value[0];
  const Eigen::Vector3d axis_s = input.scenario.lidar.scan_axis_s.normalized();
  active->laser_vector.emplace_back([axis_s](const Eigen::Vector3d& u_s) {
    const Eigen::Vector3d in_plane_s = u_s - axis_s.dot(u_s) * axis_s;
    return Eigen::Vector3d(u_s.norm() * in_plane_s.normalized());
  });
}

}  // namespace dn::effects
