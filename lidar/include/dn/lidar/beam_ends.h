#pragma once

#include <dn/lidar/pairs.h>

#include <cstddef>
#include <vector>

namespace dn {

/// Ends of pairs that one scanner measured, counted by its beams.
struct BeamEnds {
  std::vector<long> of_beam;  ///< index: number of the beam
  long without_beam = 0;      ///< ends of pairs that name no beam

  /// Returns whether the scanner measured any pair.
  bool any() const;
};

/// Counts the ends of a scanner. `beams` is the least size of `of_beam`, which is longer if a pair
/// names a higher beam.
BeamEnds CountBeamEnds(const std::vector<LidarPair>& pairs, std::size_t scanner, std::size_t beams);

/// Returns the number of beams with at least one end.
std::size_t NumMeasuredBeams(const std::vector<long>& ends_of_beam);

}  // namespace dn
