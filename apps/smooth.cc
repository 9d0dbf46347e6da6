#include <dn/calibration/filter_separation.h>
#include <dn/calibration/words.h>
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "flight_run.h"

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
  for (std::size_t k = 0; k < network.nodes.size(); ++k) {
    points.push_back(ToNavPoint(network.NodePose(k), flight_run.flight.frame));
  }
  return FindStrips(Trajectory(std::move(points)));
}

// What `dn calibrate --method gh` needs to know how the errors of the trajectory correlate.
void AddCovarianceFile(const FlightRun& flight_run, Run* run) {
  const TrajectoryCovariance covariance = flight_run.solution->PoseCovariance(Strips(flight_run));
  if (covariance.t_s.empty()) return;
  run->AddFile("trajectory_covariance.txt", FormatTrajectoryCovariance(covariance));
}

void PrintSeparation(const FilterSeparation& separation) {
  if (separation.epochs.empty()) {
    fmt::print(
        "forward/reverse separation: none; no time at which both filters know the heading\n");
    return;
  }
  const SeparationAt rms = separation.Rms(), max = separation.Max();
  const auto print = [](const char* name, const char* axes, const Eigen::Vector3d& of_rms,
                        const Eigen::Vector3d& of_max) {
    fmt::print("  {:<26} rms {:.4f}, {:.4f}, {:.4f}; largest {:.4f}, {:.4f}, {:.4f} {}\n", name,
               of_rms.x(), of_rms.y(), of_rms.z(), of_max.x(), of_max.y(), of_max.z(), axes);
  };
  fmt::print("forward/reverse separation at {} GNSS epochs after alignment\n",
             separation.epochs.size());
  print("position east, north, up", "m", rms.position_enu_m, max.position_enu_m);
  print("roll, pitch, heading", "deg", rms.rph_rad * kDegPerRad, max.rph_rad * kDegPerRad);
}

void Smooth(const SmoothOptions& options, Run& run) {
  const std::unique_ptr<FlightRun> flight_run =
      AdjustFlight(ReadFlightConfig(options.flight, options.common.changes), false, &run);
  const TrajectoryResult& trajectory = flight_run->solution->trajectory();
  const ModelCheck& check = flight_run->solution->model_check();
  AddTrajectoryFiles(*flight_run, &run);
  AddCovarianceFile(*flight_run, &run);
  run.progress.Stage("forward and reverse filter");
  const FilterSeparation separation = SeparateFilters(flight_run->adjustment());
  if (!separation.epochs.empty()) {
    run.AddFile("filter_separation.txt", FormatSeparation(separation));
  }
  Json smooth = SmoothJson(flight_run->flight.config.name, trajectory, check,
                           flight_run->solution->Unknowns(), flight_run->timings);
  smooth["separation"] = SeparationJson(separation);
  run.AddFile("smooth.json", FormatJson(smooth));
  FillReport(*flight_run, &run);
  const AdjustmentFigures& figures = trajectory.figures;
  fmt::print("flight {}: {} nodes, {} inertial and {} GNSS epochs, alignment {}\n",
             flight_run->flight.config.name, figures.nodes, figures.imu_epochs, figures.gnss_epochs,
             flight_run->adjustment().alignment_method);
  fmt::print("converged in {} iterations, sigma0 {:.3f}, chi2 {:.1f} with redundancy {}\n",
             figures.iterations, figures.sigma0, figures.chi2, figures.redundancy);
  PrintSeparation(separation);
  PrintStatistics("innovations of the forward filter (expected mean 0, variance 1, NIS 1)",
                  trajectory.innovations);
  PrintStatistics("residuals after the adjustment", trajectory.residuals);
  const Json& errors = run.report["reference_errors"];
  if (!errors.is_null()) fmt::print("differences from the reference: {}\n", errors.dump());
  PrintClocks(check.clocks);
  PrintFindings(check);
  if (check.contradicted()) ThrowContradicted(Words(check.findings.front()), "smooth.json");
}

}  // namespace

void AddSmooth(CLI::App* program, Action* action) {
  auto options = std::make_shared<SmoothOptions>();
  CLI::App* app =
      program->add_subcommand("smooth", "INS/GNSS only: the optimally smoothed trajectory");
  AddFlightOptions(app, &options->flight, &options->common);
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
