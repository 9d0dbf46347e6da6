#pragma once

#include <dn/calibration/adjust.h>
#include <dn/flight/flight.h>
#include <dn/geo/trajectory_covariance.h>
#include <dn/solvers/marginals.h>

#include <vector>

namespace dn {

/// Joint covariance of the adjusted poses at nodes spread evenly over the strips, up to 64 and at
/// least two in each; nothing (no epochs) without strips, or with more than 32.
///
/// Six columns of the covariance matrix are solved for per node.
TrajectoryCovariance ExtractTrajectoryCovariance(const Adjustment& adjustment,
                                                 const Marginals& marginals,
                                                 const std::vector<StripInterval>& strips);

}  // namespace dn
