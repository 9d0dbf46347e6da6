#pragma once

#include <dn/files/flight.h>

#include <map>
#include <string>
#include <vector>

namespace dn::apps {

/// Flight line of a strip, from the trajectory or, without one, from the GNSS positions.
struct StripLine {
  StripInterval strip;
  bool known = false;       ///< the positions cover the strip's time interval
  double length_m = 0.0;    ///< distance between start and end
  double course_rad = 0.0;  ///< clockwise from north, in [0, 2 pi)
  double height_m = 0.0;    ///< mean height above the ellipsoid
};

std::vector<StripLine> StripLines(const Flight& flight, const std::vector<StripInterval>& strips);

/// Pairs between two strips.
struct StripPairs {
  long count = 0;
  /// Number of tenths of the two strips (0 to 20) that contain a point of a pair.
  int tenths = 0;
};

/// Counts the pairs between strips. Keys are like "1-2", the earlier strip first; "?" is an epoch
/// outside all strips.
std::map<std::string, StripPairs> CountStripPairs(const Flight& flight,
                                                  const std::vector<StripInterval>& strips);

/// Describes in one sentence which angles the flight lines determine; empty if the lines are
/// unknown. mean_range_m: mean laser range of the pairs, m.
std::string DescribeGeometry(const std::vector<StripLine>& lines, double mean_range_m);

}  // namespace dn::apps
