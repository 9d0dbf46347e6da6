#pragma once

#include <dn/builder/flight_network.h>
#include <dn/calibration/candidate_effects.h>
#include <dn/calibration/lidar_effects.h>
#include <dn/flight/flight.h>

#include <cstddef>
#include <vector>

namespace dn {

/// More strips than a test of all of them together is good for.
inline constexpr std::size_t kMostStripsTogether = 24;

struct ScanAngleRange {
  double low_rad = 0.0, high_rad = 0.0;
};

/// The range of the scan angles that occur, widened to nadir; never empty.
ScanAngleRange ScanAnglesOf(const LidarConfig& lidar, const std::vector<PairEnds>& pairs);

/// Ways in which laser vectors may be off that no effect of the table is: what has no name can be
/// found by them, and is never corrected.

/// The laser vectors are off by a smooth function of the scan angle: Gaussian bumps from one angle to
/// another, three components (sensor axes, m) each.
OwnEffect LaserByScanAngle(const LidarConfig& lidar, const ScanAngleRange& range);
/// The same over the scan angles of the network's pairs, or of these.
OwnEffect LaserByScanAngle(const FlightNetwork& network);
OwnEffect LaserByScanAngle(const LidarConfig& lidar, const std::vector<PairEnds>& pairs);

/// The laser vectors are off by a constant in each strip: three components (sensor axes, m) each.
OwnEffect LaserByStrip(const std::vector<StripInterval>& strips);

}  // namespace dn
