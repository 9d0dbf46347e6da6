#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>

namespace dn {

/// When the pulses of a strip leave, and where to, in the sensor frame. The beams of a line sweep
/// over the field of view at an even rate, always from the same side, without pause; those of a cone
/// go round.
class ScanTiming {
 public:
  /// At the height over ground and with the speed of the strip. The scan rate r makes the spacing
  /// of the points along the track, v / r, that along the scan below the scanner, r w / f, with f
  /// the pulses a second and w the scan's length: H fov for a line, 2 pi H tan(fov / 2) for a cone.
  ScanTiming(const LidarScenario& lidar, double height_m, double speed_mps);

  double scan_rate_hz() const { return scan_rate_hz_; }

  /// Direction (unit vector, sensor frame) in which the beam leaves, `since_s` after the strip's
  /// begin.
  Eigen::Vector3d Direction(double since_s) const;

 private:
  ScanPattern pattern_;
  double fov_rad_;
  double scan_rate_hz_;
  Eigen::Vector3d ahead_s_, aside_s_, down_s_;  // of a line: across its plane, in it, nadir in it
};

}  // namespace dn
