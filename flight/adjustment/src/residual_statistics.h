#pragma once

#include <dn/report/statistics.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Returns statistics of the whitened residuals after the fit, per group of factors and axis, in
/// time order. They are normalised with the variances from the redundancy numbers. Measurements
/// come before processes, each in the order of their first tags. `redundancy`: RedundancyNumbers of
/// every row.
std::vector<SeriesStatistics> ResidualStatistics(const LinearizedNetwork& linearized,
                                                 const Eigen::VectorXd& redundancy);

}  // namespace dn
