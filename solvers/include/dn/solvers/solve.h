#pragma once

#include <dn/network.h>
#include <dn/solvers/shared_analysis.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>

namespace dn {

/// What SolveOptions::on_iteration is told after every iteration.
struct IterationProgress {
  int iteration = 0;         ///< 0: the initial values
  double cost = 0.0;         ///< half the sum of rho(|r|^2), unitless
  double cost_change = 0.0;  ///< decrease by this iteration; negative for a rejected step
  double step_norm = 0.0;    ///< of the step in stored coordinates, mixed units
};

/// Options of Solve. The defaults end where rounding does, and get there from far: from both starts
/// of every problem of the NIST reference data sets for non-linear regression.
struct SolveOptions {
  int max_iterations = 1000;
  int threads = 1;  ///< evaluation of the factors, and factorisation
  double function_tolerance = 1e-15;
  double parameter_tolerance = 1e-12;
  double gradient_tolerance = 1e-15;
  /// Ends also where an iteration lowers the cost by less than half the square of this: the step was
  /// shorter than so many standard deviations, all unknowns taken together. 0: never.
  double sigma_tolerance = 0.0;
  /// Of the first step, in units of the Jacobi-scaled unknowns; larger is nearer to Gauss-Newton,
  /// for good initial values.
  double initial_trust_region_radius = 1e4;
  /// A network of 100 blocks or more begins with Gauss-Newton steps; false: with damped ones.
  bool begin_undamped = true;
  /// A solution that ends on a flat, where an unknown that had influence has lost it, is tried
  /// again from the initial values by shorter steps. Costs two evaluations.
  bool second_attempt = true;
  /// Where given, shared with what was solved with it before; see SharedAnalysis.
  std::shared_ptr<SharedAnalysis> analysis = {};
  /// Called after every iteration, from the thread that called Solve; false stops the solution.
  std::function<bool(const IterationProgress&)> on_iteration = {};

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// The cost of a network at its current values.
struct CostSummary {
  double cost = 0.0;   ///< 1/2 sum rho(|r|^2) over the active factors, unitless
  long residuals = 0;  ///< number of residuals of the active factors
  int parameters = 0;  ///< tangent size of the blocks that are free and have an active factor

  /// Residuals less parameters.
  long redundancy() const { return residuals - parameters; }

  /// The scatter of the residuals, sqrt(2 cost / redundancy): 1 where the stated sigmas are true. A
  /// covariance is of the stated sigmas; times sigma0^2 it is of the residuals' own scatter, as
  /// where only the ratios of the sigmas were known. NaN without redundancy.
  double sigma0() const {
    return redundancy() > 0 ? std::sqrt(2.0 * cost / static_cast<double>(redundancy()))
                            : std::numeric_limits<double>::quiet_NaN();
  }
};

/// How a solution ended.
struct SolveReport {
  bool converged = false;    ///< a tolerance was met
  bool interrupted = false;  ///< on_iteration returned false
  int iterations = 0;        ///< accepted and rejected steps, of both attempts
  double initial_cost = 0.0;
  double final_cost = 0.0;
  CostSummary adjusted;  ///< the network as it was left: redundancy, sigma0
  double time_s = 0.0;
  std::string message;  ///< why it stopped; names the factor when one is undefined
};

/// Minimises 1/2 sum_i rho_i(|r_i|^2) over the blocks that are not held, and leaves the result in
/// the network. A network of 100 blocks or more takes Gauss-Newton steps with a sparse Cholesky
/// factorisation of the normal equations, analysed once, as long as each lowers the cost about as
/// the linear model says; from there, and smaller ones from the start, Levenberg-Marquardt steps
/// by Ceres.
///
/// Only active factors count; a block without an active factor keeps its value. A network that
/// cannot be solved numerically is reported (converged = false), and keeps its best values so far,
/// also where a solution ends on a flat twice; a rank deficient one may converge to any of its
/// solutions: see Marginals. Throws InvalidConfig for bad options, and InvalidInput naming the
/// factor that throws. Nothing is printed.
[[nodiscard]] SolveReport Solve(Network& network, const SolveOptions& options = {});

/// Evaluates the active factors. Throws InvalidInput naming the factor where one is undefined at
/// the current values. The result does not depend on the number of threads.
CostSummary EvaluateCost(const Network& network, int threads = 1);

}  // namespace dn
