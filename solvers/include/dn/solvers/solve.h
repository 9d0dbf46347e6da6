#pragma once

#include <dn/network.h>
#include <dn/solvers/shared_analysis.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace dn {

/// Argument of SolveOptions::on_iteration after each iteration.
struct IterationProgress {
  int iteration = 0;  ///< 0 for the initial values
  double cost = 0.0;  ///< half the sum of rho(|r|^2), unitless
  /// Decrease of the cost by this iteration; negative for a rejected step.
  double cost_change = 0.0;
  double step_norm = 0.0;  ///< norm of the step in stored coordinates, mixed units
};

/// Options of Solve. With the defaults, iterations continue down to rounding error and converge
/// from distant initial values. They do so from both starts of every problem of the NIST reference
/// data sets for non-linear regression.
struct SolveOptions {
  int max_iterations = 1000;
  int threads = 1;  ///< for the evaluation of the factors
  double function_tolerance = 1e-15;
  double parameter_tolerance = 1e-12;
  double gradient_tolerance = 1e-15;
  /// Also stops after an iteration that lowers the cost by less than half the square of this value.
  /// The step was then shorter than this many standard deviations of all unknowns together. 0
  /// disables the criterion.
  double sigma_tolerance = 0.0;
  /// Trust region of the first step, in units of the Jacobi-scaled unknowns. With good initial
  /// values, a larger radius gives steps nearer to Gauss-Newton.
  double initial_trust_region_radius = 1e4;
  /// Starts a network of 100 blocks or more with Gauss-Newton steps; if false, with damped steps.
  bool start_undamped = true;
  /// Repeats a solution from the initial values with shorter steps if it ends on a plateau. On a
  /// plateau, an unknown has lost its influence on the residuals. The check costs two evaluations.
  bool second_attempt = true;
  /// Throws InvalidInput before the first step if CheckJacobians finds a fault in one of three
  /// factors of each class. By default, programs that are compiled without NDEBUG check.
#ifdef NDEBUG
  bool check_jacobians = false;
#else
  bool check_jacobians = true;
#endif
  /// If given, the elimination order and its analysis are shared with other solutions; see
  /// SharedAnalysis.
  std::shared_ptr<SharedAnalysis> analysis = {};
  /// Called after every iteration, in the thread that called Solve. Returning false stops the
  /// solution.
  std::function<bool(const IterationProgress&)> on_iteration = {};

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// Cost of a network at its current values.
struct CostSummary {
  double cost = 0.0;   ///< 1/2 sum rho(|r|^2) over the active factors, unitless
  long residuals = 0;  ///< number of residuals of the active factors
  /// Tangent size of the blocks that are not constant and have an active factor.
  int parameters = 0;

  /// Returns residuals - parameters.
  long redundancy() const { return residuals - parameters; }

  /// Returns the a-posteriori standard deviation of unit weight, sqrt(2 cost / redundancy); about 1
  /// if the stated sigmas are true. A covariance follows from the stated sigmas. Multiply it by
  /// sigma0^2 if only the ratios of the sigmas are known. NaN without redundancy.
  double sigma0() const {
    return redundancy() > 0 ? std::sqrt(2.0 * cost / static_cast<double>(redundancy()))
                            : std::numeric_limits<double>::quiet_NaN();
  }
};

/// Outcome of a solution.
struct SolveSummary {
  bool converged = false;     ///< true if a tolerance was met
  bool interrupted = false;   ///< true if on_iteration returned false
  int iterations = 0;         ///< accepted and rejected steps of both attempts
  double initial_cost = 0.0;  ///< NaN if a factor is undefined at the initial values
  double final_cost = 0.0;    ///< NaN likewise
  CostSummary adjusted;  ///< cost of the network at the final values, with redundancy and sigma0
  double time_s = 0.0;
  /// Reasons to distrust the result: priors of Eliminate that have moved too far.
  std::vector<std::string> warnings;
  std::string message;  ///< reason for stopping; names the factor if one is undefined
};

/// Minimises 1/2 sum_i rho_i(|r_i|^2) over the blocks that are not constant, and stores the result
/// in the network. A network of 100 blocks or more starts with Gauss-Newton steps: a sparse
/// Cholesky factorisation of the normal equations, analysed once. They continue as long as each
/// lowers the cost about as the linear model predicts. After that, and for smaller networks from
/// the start, Ceres takes Levenberg-Marquardt steps.
///
/// Only active factors count; a block without an active factor keeps its value. If a network cannot
/// be solved numerically, or ends on a plateau twice, the summary says so (converged = false). The
/// network then keeps its best values. A rank-deficient network may converge to any of its
/// solutions: see Marginals. Throws InvalidConfig for bad options, and InvalidInput naming the
/// factor if a factor throws. Prints nothing.
[[nodiscard]] SolveSummary Solve(Network& network, const SolveOptions& options = {});

/// Evaluates the active factors. Throws InvalidInput naming the factor if one is undefined at the
/// current values. The result does not depend on the number of threads.
CostSummary EvaluateCost(const Network& network, int threads = 1);

}  // namespace dn
