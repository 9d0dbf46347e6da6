#include "effects/physics.h"

namespace dn::effects {

void LidarScanCone(const EffectInput& input, ActiveEffects* active) {
  const double angle_rad = input.value[0];
  // An effect of size zero must not even change the rounding of the vectors.
  if (angle_rad == 0.0) return;
  active->scan_cone_rad += angle_rad;
  const LidarScenario& lidar = input.scenario.lidar;
  const Eigen::Vector3d axis_s = lidar.scan_axis_s.normalized();
  if (lidar.pattern == ScanPattern::kCone) {
    active->laser_vector.emplace_back([axis_s, angle_rad](const Eigen::Vector3d& u_s, double) {
      return TurnedTowardAxis(axis_s, -angle_rad, u_s);
    });
    return;
  }
  active->laser_vector.emplace_back([axis_s](const Eigen::Vector3d& u_s, double) {
    const Eigen::Vector3d in_plane_s = u_s - axis_s.dot(u_s) * axis_s;
    return Eigen::Vector3d(u_s.norm() * in_plane_s.normalized());
  });
}

}  // namespace dn::effects
