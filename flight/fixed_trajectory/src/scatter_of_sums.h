#pragma once

#include <dn/solvers/trajectory_scatter.h>

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "node_sums.h"
#include "time_nodes.h"

namespace dn::internal {

/// The scatter of all that an adjustment estimates.
struct ScatterOfSums {
  TrajectoryScatter scatter;
  Eigen::MatrixXd covariance;  ///< of all unknowns, the boresight first
};

/// EstimateTrajectoryScatter of any adjustment with conditions on poses of a trajectory.
/// epochs_s: of the conditions kept. sums: over them, with the errors at the nodes.
ScatterOfSums EstimateScatter(double redundancy, const TrajectoryScatterOptions& options,
                              const std::function<std::vector<double>()>& epochs_s,
                              const std::function<NodeSums(const TimeNodes&)>& sums);

}  // namespace dn::internal
