#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory_covariance.h>
#include <dn/solvers/marginals.h>

#include <vector>

namespace dn {

/// Returns the joint covariance of the adjusted poses at nodes spread evenly over the strips, up to
/// 64 nodes and at least two per strip. It is empty without strips, or with more than 32.
///
/// Solves for six columns of the covariance matrix per node.
TrajectoryCovariance ExtractTrajectoryCovariance(const Adjustment& adjustment,
                                                 const Marginals& marginals,
                                                 const std::vector<StripInterval>& strips);

}  // namespace dn
