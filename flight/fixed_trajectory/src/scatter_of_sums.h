#pragma once

#include <dn/fixed_trajectory/trajectory_scatter.h>

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "node_sums.h"
#include "time_nodes.h"

namespace dn::fixed_trajectory_internal {

/// Covariance of all unknowns of an adjustment from time-correlated trajectory errors.
struct AdjustmentErrorCovariance {
  CorrelatedErrorCovariance scatter;
  Eigen::MatrixXd covariance;  ///< covariance of all unknowns, the boresight first
};

/// Implements EstimateCorrelatedErrorCovariance for any adjustment with conditions on trajectory
/// poses. `epochs_s` returns the epochs of the kept conditions; `sums` returns the sums over these
/// conditions for the given nodes.
AdjustmentErrorCovariance EstimateFromNodeSums(
    double redundancy, const TrajectoryErrorOptions& options,
    const std::function<std::vector<double>()>& epochs_s,
    const std::function<NodeSums(const TimeNodes&)>& sums);

}  // namespace dn::fixed_trajectory_internal
