#pragma once

#include <dn/files/flight.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "library.h"
#include "linear_pairs.h"

namespace dn::diagnosis_internal {

/// A place where misclosures may have a constant offset (map axes).
struct PairPlace {
  std::string location;  ///< "strips 1-2"
  std::size_t block = 0;
};

/// Effects and places tested with the pairs of a given trajectory.
struct PairLibrary {
  std::vector<EffectModel> blocks;  ///< columns whose joint score is computed
  Library library;                  ///< hypotheses about the blocks; its own blocks are empty
  std::vector<PairPlace> places;
};

/// Makes the effects of the lidar and its mount, unmodelled discrepancies of the pairs, and places.
PairLibrary MakeLibrary(const Flight& flight, const LinearPairs& pairs,
                        const std::vector<StripInterval>& strips, const LibraryOptions& options);

}  // namespace dn::diagnosis_internal
