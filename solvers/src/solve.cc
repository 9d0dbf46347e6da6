#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <dn/ceres.h>
#include <dn/error.h>
#include <dn/parallel.h>
#include <dn/solvers/check_jacobians.h>
#include <dn/solvers/eliminate.h>
#include <dn/solvers/robust_loss.h>
#include <dn/solvers/solve.h>
#include <dn/stopwatch.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "factor_text.h"
#include "flat_check.h"
#include "linearization.h"
#include "quiet_log.h"
#include "sparse/sparse.h"

namespace dn {
namespace {

/// Limit of consecutive steps to values where a factor is undefined. Each such step is at most half
/// of the previous one.
constexpr int kInvalidSteps = 20;

/// Reports each iteration to `on_iteration` and forwards its stop request. Also stops once the step
/// is below `sigma_tolerance`.
class IterationObserver final : public ceres::IterationCallback {
 public:
  explicit IterationObserver(const SolveOptions& options)
      : options_(options), least_change_(0.5 * options.sigma_tolerance * options.sigma_tolerance) {}

  /// Continues the count after iterations that were already reported. The initial state of Ceres is
  /// then not reported, because it is the end of the last of these iterations.
  void ContinueAfter(int iterations) { before_ = iterations; }
  void Restart() { before_ = -1; }

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    settled_ = s.iteration > 0 && s.step_is_successful && s.cost_change < least_change_;
    if (s.iteration == 0 && before_ >= 0) return ceres::SOLVER_CONTINUE;
    const bool go_on =
        !options_.on_iteration || options_.on_iteration({std::max(before_, 0) + s.iteration, s.cost,
                                                         s.cost_change, s.step_norm});
    if (!go_on) settled_ = false;
    return go_on && !settled_ ? ceres::SOLVER_CONTINUE : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

  /// Returns true if the last step was shorter than the tolerance.
  bool settled() const { return settled_; }

 private:
  const SolveOptions& options_;
  double least_change_;
  bool settled_ = false;
  int before_ = -1;
};

ceres::Solver::Options CeresOptions(const SolveOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.num_threads = options.threads;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.parameter_tolerance = options.parameter_tolerance;
  ceres_options.gradient_tolerance = options.gradient_tolerance;
  ceres_options.initial_trust_region_radius = options.initial_trust_region_radius;
  ceres_options.logging_type = ceres::SILENT;
  ceres_options.max_num_consecutive_invalid_steps = kInvalidSteps;
  return ceres_options;
}

/// Returns the numbers of residuals and unknowns, without the cost.
CostSummary CountNetwork(const Network& network) {
  CostSummary summary;
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    if (record.active) summary.residuals += record.factor->residual_size();
  }
  summary.parameters = UnknownLayout(network).size();
  return summary;
}

constexpr const char* kShortStep = "the last step was shorter than sigma_tolerance";
constexpr const char* kStopped = "stopped on request";

std::string EndText(sparse::GaussNewtonSummary::End end) {
  switch (end) {
    case sparse::GaussNewtonSummary::End::kGradient:
      return "the gradient is below gradient_tolerance";
    case sparse::GaussNewtonSummary::End::kCost:
      return "the last step changed the cost by less than function_tolerance";
    case sparse::GaussNewtonSummary::End::kShortStep:
      break;
  }
  return kShortStep;
}

SolveSummary FinishedSummary(const sparse::GaussNewtonSummary& steps, double time_s) {
  SolveSummary summary;
  summary.converged = !steps.interrupted;
  summary.interrupted = steps.interrupted;
  summary.iterations = steps.iterations;
  summary.initial_cost = steps.initial_cost;
  summary.final_cost = steps.final_cost;
  summary.time_s = time_s;
  summary.message = steps.interrupted ? kStopped : EndText(steps.end);
  return summary;
}

/// Returns NaN for a cost that Ceres could not compute; Ceres returns -1.
double DefinedCost(double cost) {
  return cost < 0.0 ? std::numeric_limits<double>::quiet_NaN() : cost;
}

/// Runs Ceres once from the values of the network. `observer` must be among the callbacks of
/// `options`.
SolveSummary DampedSteps(Network& network, const ceres::Solver::Options& options,
                         const IterationObserver& observer) {
  NetworkProblem problem(network);
  ceres::Solver::Summary of_ceres;
  ceres::Solve(options, &problem.problem(), &of_ceres);
  problem.RethrowFactorException();

  SolveSummary summary;
  const bool ended_here = of_ceres.termination_type == ceres::USER_SUCCESS;
  summary.converged =
      of_ceres.termination_type == ceres::CONVERGENCE || (ended_here && observer.settled());
  summary.interrupted = ended_here && !observer.settled();
  summary.iterations = std::max(0, static_cast<int>(of_ceres.iterations.size()) - 1);
  summary.initial_cost = DefinedCost(of_ceres.initial_cost);
  summary.final_cost = DefinedCost(of_ceres.final_cost);
  summary.time_s = of_ceres.total_time_in_seconds;
  summary.message = of_ceres.message;
  if (summary.interrupted) summary.message = kStopped;
  if (ended_here && observer.settled()) summary.message = kShortStep;
  if (of_ceres.termination_type == ceres::FAILURE) {
    const FactorId undefined = FindUndefinedFactor(network);
    summary.message = undefined >= 0 ? UndefinedFactorMessage(network, undefined)
                                     : "numerical failure: " + of_ceres.message;
  }
  return summary;
}

/// Networks with fewer blocks use damped steps from the start: these are cheap and converge from
/// farther away.
constexpr int kLargeNetwork = 100;

/// Takes Gauss-Newton steps if the network is large, and continues with damped steps if they do not
/// finish.
SolveSummary Attempt(Network& network, const SolveOptions& options,
                     ceres::Solver::Options ceres_options, IterationObserver* observer) {
  const Stopwatch watch;
  sparse::GaussNewtonSummary undamped;
  if (options.start_undamped && UnknownLayout(network).num_blocks() >= kLargeNetwork) {
    undamped = sparse::GaussNewton(network, options);
    if (!undamped.unfinished) return FinishedSummary(undamped, watch.seconds());
  }
  if (undamped.initial_reported) observer->ContinueAfter(undamped.iterations);
  ceres_options.max_num_iterations -= undamped.iterations;
  SolveSummary summary = DampedSteps(network, ceres_options, *observer);
  if (undamped.initial_reported) summary.initial_cost = undamped.initial_cost;
  summary.iterations += undamped.iterations;
  summary.time_s = watch.seconds();
  return summary;
}

/// Solves the network. If the solution ends on a plateau, it is repeated from the initial values.
/// In the second attempt an unknown cannot lengthen its step by losing its influence.
SolveSummary SolveTwice(Network& network, const SolveOptions& options,
                        ceres::Solver::Options ceres_options, IterationObserver* observer) {
  const PlateauCheck check(network);
  SolveSummary first = Attempt(network, options, ceres_options, observer);
  if (!first.converged || check.FindPlateauUnknown(network).empty()) return first;
  const NetworkValues first_values(network);
  check.initial().Restore(&network);
  ceres_options.min_lm_diagonal = 1.0;
  observer->Restart();
  SolveSummary second = DampedSteps(network, ceres_options, *observer);
  second.iterations += first.iterations;
  second.time_s += first.time_s;
  const bool better = second.converged || second.final_cost <= first.final_cost;
  if (second.interrupted || (better && check.FindPlateauUnknown(network).empty())) return second;
  if (!(second.final_cost <= first.final_cost)) {
    first_values.Restore(&network);
    second.final_cost = first.final_cost;
  }
  second.converged = false;
  second.message =
      "ended where '" + check.FindPlateauUnknown(network) +
      "' no longer changes the residuals; start nearer to the solution, or give this unknown a "
      "prior";
  return second;
}

template <class T>
void Require(bool valid, const char* option, T value, const char* bound) {
  if (valid) return;
  throw InvalidConfig(std::string("solve: option ") + option + " is " + std::to_string(value) +
                      ", must be " + bound);
}

}  // namespace

void SolveOptions::Validate() const {
  Require(max_iterations >= 0, "max_iterations", max_iterations, "at least 0");
  Require(threads >= 1, "threads", threads, "at least 1");
  Require(function_tolerance >= 0.0, "function_tolerance", function_tolerance, "at least 0");
  Require(parameter_tolerance >= 0.0, "parameter_tolerance", parameter_tolerance, "at least 0");
  Require(gradient_tolerance >= 0.0, "gradient_tolerance", gradient_tolerance, "at least 0");
  Require(sigma_tolerance >= 0.0, "sigma_tolerance", sigma_tolerance, "at least 0");
  Require(initial_trust_region_radius > 0.0 && initial_trust_region_radius <= 1e16,
          "initial_trust_region_radius", initial_trust_region_radius, "in (0, 1e16]");
}

SolveSummary Solve(Network& network, const SolveOptions& options) {
  options.Validate();
  if (options.check_jacobians) {
    const std::vector<JacobianFault> faults = CheckJacobians(network, {.most_per_class = 3});
    if (!faults.empty()) throw InvalidInput("solve: " + faults[0].text);
  }
  const QuietLog quiet;
  const sparse::SerialBlas serial;
  ceres::Solver::Options ceres_options = CeresOptions(options);
  IterationObserver observer(options);
  if (options.on_iteration || options.sigma_tolerance > 0.0) {
    ceres_options.callbacks.push_back(&observer);
  }
  SolveSummary summary = options.second_attempt
                             ? SolveTwice(network, options, ceres_options, &observer)
                             : Attempt(network, options, ceres_options, &observer);
  summary.adjusted = CountNetwork(network);
  summary.adjusted.cost = summary.final_cost;
  for (const MovedPrior& prior : FindMovedPriors(network)) summary.warnings.push_back(prior.text);
  return summary;
}

CostSummary EvaluateCost(const Network& network, int threads) {
  const int n = network.num_factors();
  std::vector<double> rho(static_cast<std::size_t>(n), 0.0);
  ParallelFor(n, threads, [&](int id) {
    const FactorRecord& record = network.factor(id);
    if (!record.active) return;
    Eigen::VectorXd r;
    if (!network.EvaluateFactor(id, &r) || !r.allFinite()) {
      throw InvalidInput("cost: " + UndefinedFactorMessage(network, id));
    }
    rho[static_cast<std::size_t>(id)] = EvaluateLoss(record.loss, r.squaredNorm()).rho;
  });
  CostSummary summary = CountNetwork(network);
  for (const double value : rho) summary.cost += 0.5 * value;
  return summary;
}

}  // namespace dn
