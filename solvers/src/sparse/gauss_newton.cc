#include "sparse/gauss_newton.h"

#include <dn/block.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "flat_check.h"
#include "sparse/shared_analysis_impl.h"

namespace dn::sparse {
namespace {

/// A step must achieve at least this fraction of the decrease that the linear model predicts.
constexpr double kLeastShare = 0.25;
/// Rounding error of the cost, relative to the cost.
constexpr double kCostRounding = 1e-12;
/// Square of the smallest pivot of the Jacobi-scaled N below which damped steps are used instead.
constexpr double kLeastPivot = 1e-14;

void Move(const UnknownLayout& layout, const Eigen::VectorXd& step, Network* network) {
  std::vector<double> moved;
  for (int p = 0; p < layout.num_blocks(); ++p) {
    BlockRecord& block = network->block(layout.blocks[AsSize(p)]);
    moved.resize(AsSize(block.kind.stored_size));
    Plus(block.kind, block.value.get(), step.data() + layout.offset[AsSize(p)], moved.data());
    std::copy(moved.begin(), moved.end(), block.value.get());
  }
}

class Iteration {
 public:
  Iteration(Network& network, const SolveOptions& options)
      : network_(network),
        options_(options),
        layout_(network),
        linearization_(network, layout_),
        before_(network) {}

  GaussNewtonSummary Run() {
    try {
      Steps();
    } catch (...) {
      before_.Restore(&network_);
      throw;
    }
    summary_.final_cost = cost_;
    return summary_;
  }

 private:
  enum class Outcome { kGoOn, kEnd, kTooLong };

  void Steps() {
    summary_.unfinished = true;
    if (!linearization_.Evaluate(network_, options_.threads)) return;
    summary_.initial_cost = cost_ = linearization_.cost();
    summary_.initial_reported = true;
    if (!Tell(0.0, 0.0)) return;
    const std::shared_ptr<SharedAnalysis> shared =
        options_.analysis ? options_.analysis : std::make_shared<SharedAnalysis>();
    SharedAnalysis::Impl& analysis = shared->impl();
    while (summary_.iterations < options_.max_iterations) {
      if (summary_.iterations == 0) {
        analysis.Assemble(layout_, linearization_);
      } else {
        analysis.equations->Assemble(layout_, linearization_);
      }
      const Outcome outcome = Step(*analysis.equations, *analysis.cholesky);
      if (outcome == Outcome::kTooLong) return;
      if (outcome == Outcome::kGoOn) continue;
      summary_.unfinished = false;
      return;
    }
  }

  Outcome Step(NormalEquations& equations, Cholesky& cholesky) {
    const Eigen::VectorXd gradient = linearization_.TransposeTimes(linearization_.residual());
    if (gradient.lpNorm<Eigen::Infinity>() <= options_.gradient_tolerance) {
      summary_.end = GaussNewtonSummary::End::kGradient;
      return Outcome::kEnd;
    }
    const Eigen::VectorXd scale = JacobiScale(equations.N);
    ApplyScale(scale, &equations.N);
    if (!cholesky.Factorize(equations.N)) return Outcome::kTooLong;
    if (cholesky.SmallestPivot() < kLeastPivot) return Outcome::kTooLong;
    const Eigen::VectorXd step =
        -scale.cwiseProduct(cholesky.Solve(scale.cwiseProduct(gradient)).col(0));
    return Try(step, -0.5 * gradient.dot(step));
  }

  Outcome Try(const Eigen::VectorXd& step, double predicted) {
    before_ = NetworkValues(network_);
    Move(layout_, step, &network_);
    const bool defined = linearization_.Evaluate(network_, options_.threads);
    const double change = cost_ - linearization_.cost();
    if (!defined || !(change >= kLeastShare * predicted - kCostRounding * cost_)) {
      before_.Restore(&network_);
      return Outcome::kTooLong;
    }
    ++summary_.iterations;
    cost_ = linearization_.cost();
    if (!Tell(change, step.norm())) return Outcome::kEnd;
    return Settled(std::max(change, predicted)) ? Outcome::kEnd : Outcome::kGoOn;
  }

  bool Settled(double change) {
    const bool is_short = options_.sigma_tolerance > 0.0 &&
                          change < 0.5 * options_.sigma_tolerance * options_.sigma_tolerance;
    summary_.end = is_short ? GaussNewtonSummary::End::kShortStep : GaussNewtonSummary::End::kCost;
    return is_short || change <= options_.function_tolerance * cost_;
  }

  /// Reports the iteration to on_iteration. Returns false if the solution must stop.
  bool Tell(double change, double step_norm) {
    if (!options_.on_iteration ||
        options_.on_iteration({summary_.iterations, cost_, change, step_norm})) {
      return true;
    }
    summary_.interrupted = true;
    summary_.unfinished = false;
    return false;
  }

  Network& network_;
  const SolveOptions& options_;
  UnknownLayout layout_;
  Linearization linearization_;
  NetworkValues before_;
  GaussNewtonSummary summary_;
  double cost_ = 0.0;
};

}  // namespace

GaussNewtonSummary GaussNewton(Network& network, const SolveOptions& options) {
  return Iteration(network, options).Run();
}

}  // namespace dn::sparse
