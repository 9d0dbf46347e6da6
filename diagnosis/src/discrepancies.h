#pragma once

#include <dn/builder/flight_network.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>

#include <cstddef>
#include <vector>

#include "hypothesis.h"
#include "lidar_effects.h"
#include "time_cells.h"

namespace dn::diagnosis_internal {

// These discrepancies are not effects of the table: they are tested to find unnamed causes, and are
// never corrected.

/// Largest number of strips for which LaserByStrip is tested.
inline constexpr std::size_t kMaxJointStrips = 24;

struct ScanAngleRange {
  double low_rad = 0.0, high_rad = 0.0;
};

/// Returns the range of the scan angles of the pairs, widened to include nadir; it is never empty.
ScanAngleRange FindScanAngleRange(const LidarConfig& lidar, const std::vector<PairEnds>& pairs);

/// Returns an offset of laser vectors that is a smooth function of the scan angle. The function is
/// a sum of Gaussian bumps at equal steps over the range, with three components each (sensor axes,
/// m).
Hypothesis LaserByScanAngle(const LidarConfig& lidar, const ScanAngleRange& range);
/// Returns that discrepancy of one scanner, for the scan angles of its ends of the network's pairs.
Hypothesis LaserByScanAngle(const FlightNetwork& network, std::size_t scanner);

/// Returns an offset of laser vectors that is constant in each strip, with three components each
/// (sensor axes, m).
Hypothesis LaserByStrip(const std::vector<StripInterval>& strips);

/// Returns a boresight offset that is constant in each cell: three components per cell.
Hypothesis BoresightByCell(const TimeCells& cells);

/// Returns the time constants tried for a decaying boresight offset: fractions of the time from the
/// first strip to the end of the last. Slower decay looks like a drift. `strips` must be in order
/// of time.
std::vector<double> SettlingTausS(const std::vector<StripInterval>& strips);

/// Returns a boresight offset that decays from begin_s on: three components per time constant.
Hypothesis BoresightSettling(double begin_s, const std::vector<double>& taus_s);

/// Smallest number of strips for which BoresightByHeading differs from a free boresight of each
/// strip.
inline constexpr std::size_t kFewestHeadings = 4;

/// Returns a boresight offset that follows the cosine and the sine of the heading in the middle of
/// each strip: three components each. `strips` and `path` must be in order of time, `path` not
/// empty.
Hypothesis BoresightByHeading(const std::vector<StripInterval>& strips,
                              const std::vector<MapPose>& path);

/// Returns a GNSS position offset (map axes) that is constant in each cell: three components per
/// cell.
Hypothesis GnssByCell(const TimeCells& cells);

/// Returns a GNSS position offset that is a sum of cosines; the axes are adjacent within each
/// cosine.
Hypothesis GnssByCosine(const Cosines& cosines);

/// Returns that discrepancy times |roll| / 30 deg of the trajectory (GnssProcessSigma).
Hypothesis GnssByBankAndCosine(const Cosines& cosines, const TrajectoryGraph& trajectory,
                               const LocalFrame& frame);

}  // namespace dn::diagnosis_internal
