#pragma once

#include <dn/network.h>
#include <dn/report/statistics.h>
#include <dn/solvers/marginals.h>

#include <vector>

namespace dn {

/// Whitened residuals after the fit, per sensor and axis in time order, with the variance that
/// their redundancy lets them have. `marginals` must have its selected inverse.
std::vector<SeriesStatistics> ResidualStatistics(const Network& net, const Marginals& marginals);

}  // namespace dn
