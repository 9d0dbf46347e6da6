#pragma once

#include <dn/files/flight.h>

#include <optional>
#include <string>

namespace dn {

/// Returns the offset of the time tags of the pairs, s (tag = t + offset), for which their ground
/// points agree. They must not agree as tagged. The poses are those of the trajectory, else a
/// level body along the course of the GNSS positions. Offsets up to 40 s are tried, so that leap
/// seconds are found. Returns nullopt without poses, with fewer than 20 pairs, and unless some
/// offset of at least 1 s brings the points five times closer. A boresight or a lever arm does not
/// do this. Strips flown in one direction at one speed do not determine the offset.
std::optional<double> FindPairClockOffset(const Flight& flight);

/// Describes the offset that FindPairClockOffset found and its remedy. If the poses are those of a
/// trajectory, its clock may be the wrong one, and the text says so, too.
std::string PairClockText(const Flight& flight, double offset_s);

/// A mistake in the pairs that is not that of one clock.
struct PairMistake {
  enum class Kind { kNone, kFirstTag, kSecondTag, kOneTag, kScale };
  Kind kind = Kind::kNone;
  double value = 0.0;  ///< offset of the tag, s; for kScale: factor that corrects the vectors
};

/// Returns the mistake without which the ground points of the pairs agree, in the sense of
/// FindPairClockOffset: an offset of one of the two tags, or laser vectors in feet.
PairMistake FindPairMistake(const Flight& flight);

/// Describes a mistake in the pairs and its remedy; empty without one.
std::string PairMistakeText(const PairMistake& mistake);

/// Throws InvalidInput naming the pair file and the remedy if FindPairClockOffset has a value.
void ExpectPairClock(const Flight& flight);

/// Describes an offset of lidar time tags and its remedy: "18 s early: are they in UTC? Set
/// lidar.time_offset_s: -18". declared_s: the offset that flight.yaml declares already. Leap
/// seconds are named only if the offset fits their number within its uncertainty.
std::string LidarClockHint(double offset_s, double declared_s, double sigma_s = 0.5);

}  // namespace dn
