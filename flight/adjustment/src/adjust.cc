#include <dn/adjustment/stages.h>
#include <dn/error.h>
#include <dn/navigation/gnss_lag.h>
#include <dn/stopwatch.h>

#include <string>
#include <vector>

#include "expect_pairs.h"

namespace dn {

void AdjustOptions::Validate() const {
  if (threads < 1) throw InvalidConfig("adjustment: threads must be at least 1");
  if (max_iterations < 1) throw InvalidConfig("adjustment: max_iterations must be at least 1");
  if (!with_pairs && stages.empty() && customise_before_lidar) {
    throw InvalidConfig(
        "adjustment: customise_before_lidar is not called without pairs; use customise instead");
  }
  if (!with_pairs && network.pair_model) {
    throw InvalidConfig("adjustment: network.pair_model is not called without pairs");
  }
}

namespace {

/// Runs the stages. If they do not converge, the message says whether the sensors share a motion.
void RunStages(const std::vector<AdjustmentStage>& stages, AdjustmentRun& run) {
  try {
    for (const AdjustmentStage& stage : stages) stage.run(run);
  } catch (const NotConverged& error) {
    if (GnssTagsFit(run.flight())) throw;
    throw NotConverged(
        std::string("the inertial data do not show the motion of the GNSS positions: their "
                    "accelerations agree equally with tags that are seconds or minutes off. The "
                    "clocks are far apart, the files are of different flights, or vibration hides "
                    "the motion; ") +
        error.what());
  }
}

}  // namespace

Adjustment Adjust(const Flight& flight, const AdjustOptions& options) {
  options.Validate();
  if (!flight.imu || !flight.gnss) {
    throw InvalidInput("adjustment: the flight has no inertial or GNSS data");
  }
  if (options.with_pairs) adjustment_internal::ExpectPairs(flight);
  const Stopwatch watch;
  AdjustmentRun run(flight, options);
  const auto& stages = options.stages.empty() ? DefaultStages(options.with_pairs) : options.stages;
  RunStages(stages, run);
  run.ExpectCustomised();
  run.result().residual_final_m = run.MeanPairDifference();
  run.result().time_s = watch.seconds();
  return std::move(run.result());
}

void AdjustAgain(const Flight& flight, const AdjustOptions& options, Adjustment* adjustment) {
  const Stopwatch watch;
  AdjustmentRun run(flight, options);
  run.result() = std::move(*adjustment);
  SolveFinally(run);
  run.result().residual_final_m = run.MeanPairDifference();
  run.result().time_s += watch.seconds();
  *adjustment = std::move(run.result());
}

}  // namespace dn
