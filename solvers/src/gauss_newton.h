#pragma once

#include <dn/network.h>
#include <dn/solvers/solve.h>

namespace dn {

/// How far Gauss-Newton steps came.
struct GaussNewtonReport {
  /// Neither at the end nor stopped: the values are the best so far, and shorter steps are needed.
  bool unfinished = false;
  bool interrupted = false;  ///< on_iteration returned false
  bool begun = false;        ///< the initial cost is defined, and on_iteration was told
  int iterations = 0;
  double initial_cost = 0.0;
  double final_cost = 0.0;
};

/// Moves a network by undamped steps, N dx = -J^T r, as long as each lowers the cost about as the
/// linear model says and N can be factored well. All steps share one ordering, one analysis and one
/// store of Jacobians. Ends as the tolerances of `options` say. Throws what a factor throws, and
/// leaves the network as it was then; std::bad_alloc.
GaussNewtonReport GaussNewton(Network& network, const SolveOptions& options);

}  // namespace dn
