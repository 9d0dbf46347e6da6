#pragma once

#include <dn/calibration/result.h>
#include <dn/network.h>
#include <dn/report/statistics.h>
#include <dn/solvers/marginals.h>

#include <vector>

namespace dn {

/// Whitened residuals and redundancy numbers of every active factor, by id. `marginals` must have
/// its selected inverse.
std::vector<FactorFit> FitOfFactors(const Network& net, const Marginals& marginals);

/// Whitened residuals after the fit, per sensor and axis in time order, with the variance that
/// their redundancy lets them have.
std::vector<SeriesStatistics> ResidualStatistics(const Network& net,
                                                 const std::vector<FactorFit>& fits);

}  // namespace dn
