#include "readjust.h"

#include <dn/adjustment/stages.h>
#include <dn/builder/keep_in_use.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "gnss_clock.h"
#include "gnss_step_trial.h"
#include "network_at.h"

namespace dn::adjustment_internal {
namespace {

bool EstimatesGnssClock(const FlightConfig& config) {
  return std::ranges::any_of(config.estimate, [](const EstimateEntry& entry) {
    return IsEffect(entry.unknown, EffectId::kGnssTimeOffset);
  });
}

/// Takes over the solution of another adjustment.
void StartFrom(Adjustment&& before, AdjustmentRun* run) {
  run->result().network = std::move(before.network);
  run->result().analysis = before.analysis;
  run->result().alignment_method = before.alignment_method;
  run->result().node_rate_hz = before.node_rate_hz;
}

Adjustment Finish(AdjustmentRun* run) {
  run->ExpectCustomised();
  run->result().residual_final_m = run->MeanPairDifference();
  return std::move(run->result());
}

}  // namespace

Adjustment Readjust(const Flight& flight, const AdjustOptions& options, Adjustment before) {
  AdjustmentRun run(flight, options);
  StartFrom(std::move(before), &run);
  if (flight.config.network.inertial == NetworkConfig::Inertial::kRaw) run.TakeRawInertial();
  RemakeWholeNetwork(run);
  if (options.with_pairs) AddOwnBeforeLidar(run);
  AddOwnBeforeFinal(run);
  SolveFinally(run);
  return Finish(&run);
}

Adjustment ScreenAgain(const Flight& flight, const AdjustOptions& options, Adjustment before) {
  const auto clock = before.gnss_clock;
  AdjustmentRun run(flight, options);
  StartFrom(std::move(before), &run);
  CalibrationState calibration = run.network().calibration().State();
  if (clock && EstimatesGnssClock(flight.config)) {
    AddToGnssClock(flight, clock->offset_s, clock->drift, &calibration);
  }
  std::unique_ptr<FlightNetwork> network = RemakeNetwork(run, calibration);
  KeepInUse(run.network(), network.get());
  run.result().network = std::move(network);
  std::vector<AdjustmentStage> stages = DefaultStages(options.with_pairs);
  FindStage("GNSS screening", &stages)->run = ScreenGnssOutliers;
  for (auto stage = stages.begin() + 1; stage != stages.end(); ++stage) stage->run(run);
  return Finish(&run);
}

}  // namespace dn::adjustment_internal
