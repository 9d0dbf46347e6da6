#pragma once

#include <dn/adjustment/result.h>

#include <vector>

namespace dn {

/// Returns the standard deviations of the poses at the nodes. `marginals` must have its selected
/// inverse.
std::vector<TrajectorySigma> TrajectorySigmas(const FlightNetwork& network,
                                              const Marginals& marginals);

}  // namespace dn
