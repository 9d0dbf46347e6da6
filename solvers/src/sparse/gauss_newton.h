#pragma once

#include <dn/network.h>
#include <dn/solvers/solve.h>

namespace dn::sparse {

/// Outcome of the Gauss-Newton steps.
struct GaussNewtonSummary {
  /// True if the steps neither converged nor were stopped: the values are the best so far, and
  /// shorter (damped) steps are needed.
  bool unfinished = false;
  /// Tolerance that ended the steps; only if they are finished and not interrupted.
  enum class End { kGradient, kCost, kShortStep };
  End end = End::kGradient;
  bool interrupted = false;  ///< true if on_iteration returned false
  /// True if the initial cost is defined and was reported to on_iteration.
  bool initial_reported = false;
  int iterations = 0;
  double initial_cost = 0.0;
  double final_cost = 0.0;
};

/// Moves a network by undamped steps, N dx = -J^T r. It continues as long as each step lowers the
/// cost about as the linear model predicts and N can be factored accurately. All steps share one
/// ordering, one analysis and one store of Jacobians. The steps end by the tolerances of `options`.
/// If a factor throws, the exception is passed on and the network keeps the values from before that
/// step. Also throws std::bad_alloc.
GaussNewtonSummary GaussNewton(Network& network, const SolveOptions& options);

}  // namespace dn::sparse
