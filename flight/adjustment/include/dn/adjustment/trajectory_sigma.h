#pragma once

#include <dn/calibration/result.h>

#include <vector>

namespace dn {

/// Standard deviations of the poses at the nodes. `marginals` must have its selected inverse.
std::vector<TrajectorySigma> TrajectorySigmas(const FlightNetwork& network,
                                              const Marginals& marginals);

}  // namespace dn
