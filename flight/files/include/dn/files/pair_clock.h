#pragma once

#include <dn/files/flight.h>

#include <optional>
#include <string>

namespace dn {

/// Returns the offset of the time tags of the pairs, s (tag = t + offset), for which their ground
/// points agree. They must not agree as tagged. The poses are those of the trajectory, else a
/// level body along the course of the GNSS positions. Offsets up to 25 s are tried, so that leap
/// seconds are found. Returns nullopt without poses, with fewer than 20 pairs, and unless some
/// offset of at least 1 s brings the points five times closer. A boresight or a lever arm does not
/// do this. Strips flown in one direction at one speed do not determine the offset.
std::optional<double> FindPairClockOffset(const Flight& flight);

/// Throws InvalidInput naming the pair file and the remedy if FindPairClockOffset has a value.
void ExpectPairClock(const Flight& flight);

/// Describes an offset of lidar time tags and its remedy: "18 s early: are they in UTC? Set
/// lidar.time_offset_s: -18". declared_s: the offset that flight.yaml declares already.
std::string LidarClockHint(double offset_s, double declared_s);

}  // namespace dn
