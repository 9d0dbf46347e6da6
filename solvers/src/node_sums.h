#pragma once

#include <dn/solvers/trajectory_scatter.h>

#include <Eigen/Core>

#include "time_nodes.h"

namespace dn::internal {

/// Sums over the pairs with the errors of the trajectory at the nodes, in units of their stated
/// sigmas: unknown c of node n stands at c * nodes + n; c: position north, east, down, roll, pitch,
/// heading. With a stated covariance in its units: position in map (m), attitude in body (rad).
struct NodeSums {
  Eigen::MatrixXd H, N_e;
  Eigen::VectorXd b;
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();  ///< zero, unless the estimate had other weights
  double chi2 = 0.0;
  Eigen::VectorXd heading_rad;  ///< mean at each node
};

/// J^T S J, J^T S A, J^T S w, A^T S A, A^T S w, w^T S w of the adjusted pairs.
NodeSums SumOverPairs(const GaussHelmertProblem& problem, const GaussHelmertResult& result,
                      BoresightModel model, const TrajectoryScatterOptions& options,
                      const TimeNodes& nodes);

}  // namespace dn::internal
