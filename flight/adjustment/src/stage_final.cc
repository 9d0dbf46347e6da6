#include <dn/adjustment/stages.h>

#include "relinearisations.h"

namespace dn {
namespace {

constexpr const char* kName = "final least squares";
// Bias change (in the units of BiasChange) below which integrating again changes nothing.
constexpr double kMaxBiasChange = 0.02;

}  // namespace

void SolveFinally(AdjustmentRun& run) {
  run.SetGnssLoss({});
  run.SetPairLoss({});
  for (int k = 0; k <= adjustment_internal::kMaxRepreintegrations; ++k) {
    const bool biases_unchanged = run.network().inertial().BiasChange() < kMaxBiasChange;
    if (k > 0 && biases_unchanged) break;
    if (!biases_unchanged) run.network().Repreintegrate();
    run.Solve(kName, run.options().max_iterations, run.options().final_step_sigmas);
  }
  if (run.result().converged) return;
  const StageSummary& last = run.result().stages.back();
  throw NotConverged("the final least squares did not converge in " +
                     std::to_string(run.options().max_iterations) + " iterations (cost " +
                     std::to_string(last.cost_before) + " to " + std::to_string(last.cost_after) +
                     "): " + last.message +
                     "; check the stochastic model, lever arms and the time tags of the flight");
}

}  // namespace dn
