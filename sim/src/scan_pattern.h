#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>

namespace dn {

/// Directions of the pulses of a strip over time, in the sensor frame. The beams of a line scanner
/// sweep over the field of view at constant rate, always from the same side, without pause. Those
/// of a zigzag scanner swing to and fro, and those of a conical scanner rotate. The beams of a
/// rotating scanner fire one after the other at its pulse rate.
class ScanTiming {
 public:
  /// The scan rate r follows from the height over ground and the speed v of the strip. It makes the
  /// point spacing along the track, v / r, equal to that along the scan below the scanner, r w / f.
  /// Here f is the pulse rate and w the length of a scan at the height H. It is H fov for a line,
  /// and 2 pi H tan(fov / 2) for a cone. A scan of a zigzag is the way from one side to the other.
  /// The rate of a rotating scanner is its rotation.
  ///
  /// stretch: factor of the scan rate; start: scans at the beginning of the strip.
  ScanTiming(const LidarScenario& lidar, double height_m, double speed_mps, double stretch = 1.0,
             double start = 0.0);

  double scan_rate_hz() const { return scan_rate_hz_; }
  double height_m() const { return height_m_; }

  /// Returns the direction (unit vector, sensor frame) of the beam that leaves `since_s` after the
  /// beginning of the strip.
  Eigen::Vector3d Direction(double since_s) const;

  /// Returns whether the beams of a rotating scanner then lie outside the field of view.
  bool LooksAway(double since_s) const;

 private:
  /// Returns the angle of a rotating scanner from nadir, -pi to pi.
  double Rotation(double since_s) const;

  ScanPattern pattern_;
  double fov_rad_;
  double height_m_;
  double scan_rate_hz_;
  double start_;
  // Axes of the pattern; for a line: normal of its plane, direction in the plane, nadir in the
  // plane.
  Eigen::Vector3d ahead_s_, aside_s_, down_s_;
};

}  // namespace dn
