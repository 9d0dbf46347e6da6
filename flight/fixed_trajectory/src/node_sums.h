#pragma once

#include <dn/solvers/trajectory_scatter.h>

#include <Eigen/Core>

#include "time_nodes.h"

namespace dn::internal {

/// Sums over the conditions of an adjustment with the errors of the trajectory at the nodes, in
/// units of their stated sigmas: unknown c of node n stands at c * nodes + n; c: position north,
/// east, down, roll, pitch, heading. With a stated covariance in its units: position in map (m),
/// attitude in body (rad).
struct NodeSums {
  Eigen::MatrixXd H, N_e;
  Eigen::VectorXd b;
  Eigen::MatrixXd N;  ///< of the estimated unknowns, the boresight first
  Eigen::VectorXd g;  ///< zero, unless the estimate had other weights
  double chi2 = 0.0;
  Eigen::VectorXd heading_rad;  ///< mean at each node

  NodeSums(Eigen::Index nodes, Eigen::Index unknowns);

  /// From unknown c of node n at 6 n + c, and the lower triangle of H only.
  void OrderByComponent();
};

/// Six errors of the trajectory at the epoch of an end, in the units of NodeSums.
using EndJacobian = Eigen::Matrix<double, 3, 6>;

/// d x / d errors of a georeferenced point x. J_phi: d x / d attitude correction.
EndJacobian ErrorJacobian(const GaussHelmertEnd& end, const Eigen::Matrix3d& J_phi,
                          const TrajectoryScatterOptions& options);

/// Mean heading at the nodes.
class NodeHeadings {
 public:
  explicit NodeHeadings(const TimeNodes& nodes) : nodes_(nodes) {
    north_east_.setZero(nodes.size(), 2);
  }
  void Add(const GaussHelmertEnd& end);
  Eigen::VectorXd heading_rad() const;

 private:
  const TimeNodes& nodes_;
  Eigen::MatrixX2d north_east_;  // sums of the forward axes
};

/// J^T S J, J^T S A, J^T S w, A^T S A, A^T S w, w^T S w of the adjusted pairs.
NodeSums SumOverPairs(const GaussHelmertProblem& problem, const GaussHelmertResult& result,
                      BoresightModel model, const TrajectoryScatterOptions& options,
                      const TimeNodes& nodes);

}  // namespace dn::internal
