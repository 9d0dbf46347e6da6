#pragma once

#include <dn/flight/flight.h>

#include <map>
#include <string>
#include <vector>

namespace dn::apps {

/// A strip as it was flown, from the trajectory or, without one, the GNSS positions.
struct StripLine {
  StripInterval strip;
  bool known = false;       ///< the positions cover it
  double length_m = 0.0;    ///< between its ends
  double course_rad = 0.0;  ///< from north over east, in [0, 2 pi)
  double height_m = 0.0;    ///< mean, above the ellipsoid
};

std::vector<StripLine> StripLines(const Flight& flight, const std::vector<StripInterval>& strips);

/// The pairs that join two strips.
struct StripPairs {
  long count = 0;
  /// Tenths of the two strips, of twenty, that hold an end of one.
  int tenths = 0;
};

/// By "1-2", the earlier strip first; "?" for an epoch outside of all strips.
std::map<std::string, StripPairs> PairsOfStrips(const Flight& flight,
                                                const std::vector<StripInterval>& strips);

/// What the lines determine, a sentence; empty where they are not known. mean_range_m: of the pairs.
std::string GeometryInWords(const std::vector<StripLine>& lines, double mean_range_m);

}  // namespace dn::apps
