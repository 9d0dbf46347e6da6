#pragma once

#include <dn/builder/flight_network.h>
#include <dn/files/flight.h>

#include <cstddef>
#include <vector>

#include "candidate_effects.h"
#include "lidar_effects.h"

namespace dn {

/// Largest number of strips for which LaserByStrip is tested.
inline constexpr std::size_t kMaxJointStrips = 24;

struct ScanAngleRange {
  double low_rad = 0.0, high_rad = 0.0;
};

/// Returns the range of the scan angles of the pairs, widened to include nadir; it is never empty.
ScanAngleRange FindScanAngleRange(const LidarConfig& lidar, const std::vector<PairEnds>& pairs);

/// Returns the discrepancy that offsets laser vectors by a smooth function of the scan angle. The
/// function is a sum of Gaussian bumps at equal steps over the range, with three components each
/// (sensor axes, m). The discrepancies of this header are not effects of the table: they are tested
/// to find unnamed causes, and are never corrected.
UserEffect LaserByScanAngle(const LidarConfig& lidar, const ScanAngleRange& range);
/// These two functions return that discrepancy for the scan angles of the network's pairs, or of
/// the given pairs.
UserEffect LaserByScanAngle(const FlightNetwork& network);
UserEffect LaserByScanAngle(const LidarConfig& lidar, const std::vector<PairEnds>& pairs);

/// Returns the discrepancy that offsets laser vectors by a constant in each strip, with three
/// components each (sensor axes, m).
UserEffect LaserByStrip(const std::vector<StripInterval>& strips);

}  // namespace dn
