#pragma once

#include <dn/fixed_trajectory/trajectory_scatter.h>

#include <Eigen/Core>

#include "time_nodes.h"

namespace dn::fixed_trajectory_internal {

/// Normal-equation sums over the conditions of an adjustment, with the trajectory errors at the
/// nodes as additional unknowns. The errors are in units of their stated sigmas. Error c of node n
/// has index c * nodes + n, with c: position north, east, down, roll, pitch, heading. If a
/// covariance over time is stated, the errors have its units instead: position in map (m), attitude
/// in body (rad).
struct NodeSums {
  Eigen::MatrixXd H, N_e;
  Eigen::VectorXd b;
  Eigen::MatrixXd N;  ///< normal matrix of the estimated unknowns, the boresight first
  Eigen::VectorXd g;  ///< gradient; zero unless the estimate used other weights
  double chi2 = 0.0;
  Eigen::VectorXd heading_rad;  ///< mean heading at each node

  NodeSums(Eigen::Index nodes, Eigen::Index unknowns);

  /// Reorders the sums from index 6 n + c to c * nodes + n, and fills H from its lower triangle.
  void OrderByComponent();
};

/// d x / d the six trajectory errors at the epoch of an end, in the units of NodeSums.
using EndJacobian = Eigen::Matrix<double, 3, 6>;

/// Returns d x / d errors of a georeferenced point x. J_phi is d x / d attitude correction.
EndJacobian ErrorJacobian(const GaussHelmertEnd& end, const Eigen::Matrix3d& J_phi,
                          const TrajectoryErrorOptions& options);

/// Accumulates the mean heading at the nodes.
class NodeHeadings {
 public:
  explicit NodeHeadings(const TimeNodes& nodes) : nodes_(nodes) {
    north_east_.setZero(nodes.size(), 2);
  }
  void Add(const GaussHelmertEnd& end);
  Eigen::VectorXd heading_rad() const;

 private:
  const TimeNodes& nodes_;
  Eigen::MatrixX2d north_east_;  // sums of the horizontal forward axes
};

/// Sums J^T S J, J^T S A, J^T S w, A^T S A, A^T S w and w^T S w over the adjusted pairs.
NodeSums SumPairConditions(const GaussHelmertProblem& problem, const GaussHelmertResult& result,
                           BoresightModel model, const TrajectoryErrorOptions& options,
                           const TimeNodes& nodes);

}  // namespace dn::fixed_trajectory_internal
