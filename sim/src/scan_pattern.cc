#include "scan_pattern.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace dn {
namespace {

double ScanLength(const LidarScenario& lidar, double height_m) {
  if (lidar.pattern == ScanPattern::kLine) return height_m * lidar.fov_rad;
  return 2.0 * std::numbers::pi * height_m * std::tan(0.5 * lidar.fov_rad);
}

}  // namespace

ScanTiming::ScanTiming(const LidarScenario& lidar, double height_m, double speed_mps)
    : pattern_(lidar.pattern),
      fov_rad_(lidar.fov_rad),
      scan_rate_hz_(std::sqrt(speed_mps * lidar.pulse_rate_hz / ScanLength(lidar, height_m))),
      ahead_s_(lidar.scan_axis_s.normalized()),
      aside_s_(ahead_s_.cross(lidar.nadir_axis_s).normalized()),
      down_s_(aside_s_.cross(ahead_s_)) {
  if (pattern_ == ScanPattern::kLine) return;
  down_s_ = lidar.nadir_axis_s.normalized();
  ahead_s_ = down_s_.cross(aside_s_);
}

Eigen::Vector3d ScanTiming::Direction(double since_s) const {
  const double scans = since_s * scan_rate_hz_;
  const double phase = scans - std::floor(scans);
  if (pattern_ == ScanPattern::kLine) {
    const double angle = (phase - 0.5) * fov_rad_;
    return std::cos(angle) * down_s_ + std::sin(angle) * aside_s_;
  }
  const double azimuth = 2.0 * std::numbers::pi * phase, half = 0.5 * fov_rad_;
  return std::cos(half) * down_s_ +
         std::sin(half) * (std::cos(azimuth) * ahead_s_ + std::sin(azimuth) * aside_s_);
}

}  // namespace dn
