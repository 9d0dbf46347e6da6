#include <cmath>
#include <functional>

#include "effects/physics.h"

namespace dn::effects {
namespace {

/// Rotates the true beams towards the scan axis, while the file assumes that they do not turn.
void Lean(const EffectInput& input, const std::function<double(double scan_angle_rad)>& lean_rad,
          ActiveEffects* active) {
  // An effect of size zero must not even change the rounding of the vectors.
  if (input.value.isZero(0.0)) return;
  ActiveEffects alone;
  alone.scan_lean_rad.push_back(lean_rad);
  active->scan_lean_rad.push_back(lean_rad);
  const LidarScenario& lidar = input.scenario.lidar;
  const Eigen::Vector3d axis_s = lidar.scan_axis_s.normalized();
  if (lidar.pattern == ScanPattern::kCone || lidar.pattern == ScanPattern::kRotating) {
    active->laser_vector.emplace_back([alone, lidar, axis_s](const Eigen::Vector3d& u_s, double) {
      return TurnedTowardAxis(axis_s, -ScanLean(alone, lidar, u_s), u_s);
    });
    return;
  }
  active->laser_vector.emplace_back([axis_s](const Eigen::Vector3d& u_s, double) {
    const Eigen::Vector3d in_plane_s = u_s - axis_s.dot(u_s) * axis_s;
    return Eigen::Vector3d(u_s.norm() * in_plane_s.normalized());
  });
}

}  // namespace

void LidarScanCone(const EffectInput& input, ActiveEffects* active) {
  Lean(
      input, [angle_rad = input.value[0]](double) { return angle_rad; }, active);
}

void LidarScanTorsion(const EffectInput& input, ActiveEffects* active) {
  const double amplitude_rad = input.value[0];
  Lean(
      input,
      [amplitude_rad](double scan_angle_rad) {
        return amplitude_rad * std::sin(4.0 * scan_angle_rad);
      },
      active);
}

}  // namespace dn::effects
