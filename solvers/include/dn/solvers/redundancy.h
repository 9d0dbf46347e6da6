#pragma once

#include <dn/network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>

namespace dn {

/// Variance that each whitened residual of a factor should have after the fit: its redundancy
/// number
///
///   diag(I - J C J^T),  C = N^-1,
///
/// between 0 (the residual is fitted away) and 1 (the unknowns do not follow it). Over all active
/// factors they sum to residuals minus parameters. Divided by its square root, a residual is
/// standard normal when the model holds (Baarda's w).
///
/// `marginals` must be of this network at its present values, with its selected inverse. Throws
/// InvalidInput when it has none, or the factor is undefined or not active.
Eigen::VectorXd RedundancyNumbers(const Network& network, FactorId factor,
                                  const Marginals& marginals);

}  // namespace dn
