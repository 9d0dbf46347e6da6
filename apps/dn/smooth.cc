#include <dn/adjustment/filter_separation.h>
#include <dn/adjustment/words.h>

#include <optional>
#include <utility>
#include <vector>

#include "flight_run.h"
#include "noise_output.h"
#include "shaking_json.h"
#include "smooth_summary.h"

namespace dn::apps {
namespace {

struct SmoothOptions {
  CommonOptions common;
  std::string flight;
};

std::vector<StripInterval> Strips(const FlightRun& flight_run) {
  if (!flight_run.flight.config.strips.empty()) return flight_run.flight.config.strips;
  const FlightNetwork& network = flight_run.solution->network();
  std::vector<NavPoint> points;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    points.push_back(ToNavPoint(network.trajectory().NodePose(k), flight_run.flight.frame));
  }
  return FindStrips(Trajectory(std::move(points)));
}

// Stages the trajectory covariance, from which `dn calibrate --method gh` takes the correlation of
// the trajectory errors.
void AddCovarianceFile(const FlightRun& flight_run, Run* run) {
  const TrajectoryCovariance covariance = flight_run.solution->PoseCovariance(Strips(flight_run));
  if (covariance.t_s.empty()) return;
  run->AddFile("trajectory_covariance.txt", FormatTrajectoryCovariance(covariance));
}

void Smooth(const SmoothOptions& options, Run& run) {
  const std::unique_ptr<FlightRun> flight_run =
      AdjustFlight(ReadFlightConfig(options.flight, options.common.changes), false, &run);
  const TrajectoryResult& trajectory = flight_run->solution->trajectory();
  const ModelCheck& check = flight_run->solution->model_check();
  AddTrajectoryFiles(*flight_run, &run);
  AddCovarianceFile(*flight_run, &run);
  run.progress().Stage("forward and reverse filter");
  const FilterSeparation separation = SeparateFilters(flight_run->adjustment());
  if (!separation.epochs.empty()) {
    run.AddFile("filter_separation.txt", FormatSeparation(separation));
  }
  Json smooth =
      SmoothJson(flight_run->flight.config.name, trajectory, flight_run->solution->CheckedSigmas(),
                 check, flight_run->solution->CheckedUnknowns(), flight_run->timings);
  if (flight_run->noise) AddNoise(*flight_run->noise, &smooth);
  smooth["separation"] = SeparationJson(separation);
  const std::optional<Shaking> shaking = FindShaking(*flight_run->flight.imu);
  smooth["shaking"] = ShakingJson(shaking);
  run.AddFile("smooth.json", FormatJson(smooth));
  FillReport(*flight_run, &run);
  PrintSmoothSummary(*flight_run, separation, run.report()["reference_errors"]);
  PrintNoise(flight_run->noise);
  PrintShaking(shaking, "");
  if (check.contradicted()) ThrowContradicted(Words(check.findings.front()), "smooth.json");
}

}  // namespace

void AddSmooth(CLI::App* program, Action* action) {
  auto options = std::make_shared<SmoothOptions>();
  CLI::App* app =
      program->add_subcommand("smooth", "Computes the smoothed INS/GNSS trajectory, without lidar");
  AddFlightOptions(app, &options->flight, &options->common);
  AddUnmodelled(app, &options->common);
  AddCommonOptions(app, &options->common, true);
  app->footer("Example: dn smooth flight --out result");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = FlightInputs(options->flight, options->common.changes);
      return Execute("smooth", options->common, [&](Run& run) { Smooth(*options, run); });
    };
  });
}

}  // namespace dn::apps
