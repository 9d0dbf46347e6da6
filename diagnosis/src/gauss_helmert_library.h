#pragma once

#include <dn/calibration/linear_pairs.h>
#include <dn/flight/flight.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "library.h"

namespace dn::internal {

/// A place where misclosures (map axes) may be off by a constant.
struct PairPlace {
  std::string location;  ///< "strips 1-2"
  std::size_t block = 0;
};

/// What the pairs of a given trajectory are searched for.
struct GaussHelmertLibrary {
  std::vector<CandidateEffect> blocks;  ///< whose score is wanted, side by side
  Library library;                      ///< candidates among them; its own blocks are empty
  std::vector<PairPlace> places;
};

/// The effects of the lidar and of its mount, discrepancies of the pairs without a name, and places.
GaussHelmertLibrary MakeLibrary(const Flight& flight, const LinearPairs& pairs,
                                const std::vector<StripInterval>& strips,
                                const LibraryOptions& options);

}  // namespace dn::internal
