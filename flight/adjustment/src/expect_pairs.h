#pragma once

#include <dn/error.h>
#include <dn/files/flight.h>

namespace dn::adjustment_internal {

/// Throws InvalidInput if the flight has no pairs.
inline void ExpectPairs(const Flight& flight) {
  if (flight.pairs && !flight.pairs->pairs.empty()) return;
  throw InvalidInput("adjustment: the flight has no point-to-point pairs");
}

}  // namespace dn::adjustment_internal
