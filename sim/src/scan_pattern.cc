#include "scan_pattern.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace dn {
namespace {

double ScanLength(const LidarScenario& lidar, double height_m) {
  if (lidar.pattern != ScanPattern::kCone) return height_m * lidar.fov_rad;
  return 2.0 * std::numbers::pi * height_m * std::tan(0.5 * lidar.fov_rad);
}

/// Returns the angle of a swinging mirror, -1 to 1, at a phase of its period. The angle is nearly
/// proportional to the time, except for the round turns at the sides.
double Swing(double phase) {
  constexpr double kRound = 0.97;  // 1: a triangle
  return std::asin(kRound * std::sin(2.0 * std::numbers::pi * phase)) / std::asin(kRound);
}

}  // namespace

ScanTiming::ScanTiming(const LidarScenario& lidar, double height_m, double speed_mps,
                       double stretch, double start)
    : pattern_(lidar.pattern),
      fov_rad_(lidar.fov_rad),
      height_m_(height_m),
      scan_rate_hz_(stretch * (pattern_ == ScanPattern::kRotating
                                   ? lidar.beams.rotation_hz
                                   : std::sqrt(speed_mps * lidar.pulse_rate_hz /
                                               ScanLength(lidar, height_m)))),
      start_(start),
      ahead_s_(lidar.scan_axis_s.normalized()),
      aside_s_(ahead_s_.cross(lidar.nadir_axis_s).normalized()),
      down_s_(aside_s_.cross(ahead_s_)) {
  if (pattern_ != ScanPattern::kCone) return;
  down_s_ = lidar.nadir_axis_s.normalized();
  ahead_s_ = down_s_.cross(aside_s_);
}

double ScanTiming::Rotation(double since_s) const {
  const double turns = start_ + since_s * scan_rate_hz_;
  return 2.0 * std::numbers::pi * (turns - std::floor(turns) - 0.5);
}

bool ScanTiming::LooksAway(double since_s) const {
  return pattern_ == ScanPattern::kRotating && std::abs(Rotation(since_s)) > 0.5 * fov_rad_;
}

Eigen::Vector3d ScanTiming::Direction(double since_s) const {
  if (pattern_ == ScanPattern::kRotating) {
    const double angle = Rotation(since_s);
    return std::cos(angle) * down_s_ + std::sin(angle) * aside_s_;
  }
  const double scans = start_ + since_s * scan_rate_hz_;
  const double phase = scans - std::floor(scans);
  if (pattern_ == ScanPattern::kZigzag) {
    const double angle = 0.5 * fov_rad_ * Swing(0.5 * (scans - 2.0 * std::floor(0.5 * scans)));
    return std::cos(angle) * down_s_ + std::sin(angle) * aside_s_;
  }
  if (pattern_ == ScanPattern::kLine) {
    const double angle = (phase - 0.5) * fov_rad_;
    return std::cos(angle) * down_s_ + std::sin(angle) * aside_s_;
  }
  const double azimuth = 2.0 * std::numbers::pi * phase, half = 0.5 * fov_rad_;
  return std::cos(half) * down_s_ +
         std::sin(half) * (std::cos(azimuth) * ahead_s_ + std::sin(azimuth) * aside_s_);
}

}  // namespace dn
