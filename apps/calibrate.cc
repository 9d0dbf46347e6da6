#include <dn/flight/truth.h>
#include <fmt/format.h>

#include "flight_run.h"

namespace dn::apps {
namespace {

struct CalibrateOptions {
  CommonOptions common;
  std::string flight;
  std::string method = "dn";
};

void PrintMatrix(const std::string& title, const Eigen::Matrix3d& percent,
                 const std::vector<std::string>& columns) {
  const char* rows[] = {"roll", "pitch", "yaw"};
  fmt::print("{}\n  {:<6} {:>8} {:>8} {:>8}\n", title, "", columns[0], columns[1], columns[2]);
  for (int r = 0; r < 3; ++r) {
    fmt::print("  {:<6} {:>8.1f} {:>8.1f} {:>8.1f}\n", rows[r], percent(r, 0), percent(r, 1),
               percent(r, 2));
  }
}

void PrintResult(const FlightRun& flight_run, const BoresightResult& boresight,
                 const std::vector<UnknownEstimate>& unknowns) {
  const char* names[] = {"roll", "pitch", "yaw"};
  const auto truth_deg = ReadTrueBoresightDeg(flight_run.flight.config.folder);
  const Eigen::Vector3d angles_deg = boresight.angles_rad * kDegPerRad;
  const Eigen::Vector3d sigma_deg = boresight.sigma_rad() * kDegPerRad;
  fmt::print("boresight of flight {} [deg], rotation vector about the body axes\n",
             flight_run.flight.config.name);
  fmt::print("  {:<6} {:>12} {:>12}{}\n", "", "estimate", "sigma",
             truth_deg ? fmt::format(" {:>12} {:>10}", "truth", "error/sigma") : "");
  for (int i = 0; i < 3; ++i) {
    fmt::print("  {:<6} {:>12.6f} {:>12.6f}", names[i], angles_deg[i], sigma_deg[i]);
    if (truth_deg) {
      fmt::print(" {:>12.6f} {:>10.2f}", (*truth_deg)[i],
                 (angles_deg[i] - (*truth_deg)[i]) / sigma_deg[i]);
    }
    fmt::print("\n");
  }
  for (const UnknownEstimate& unknown : unknowns) {
    fmt::print("{} [{}], correction to the assumed value:", unknown.name, unknown.unit);
    for (std::size_t i = 0; i < unknown.value.size(); ++i) {
      fmt::print(" {:.6g} +- {:.2g}", unknown.value[i], unknown.sigma[i]);
    }
    fmt::print("\n");
  }
  PrintMatrix("correlation of the angles [%]", 100.0 * boresight.correlation(),
              {"roll", "pitch", "yaw"});
  PrintMatrix("with the accelerometer bias at the lidar barycentre [%]",
              100.0 * boresight.accel_bias.at_barycentre, {"x", "y", "z"});
  PrintMatrix("with the gyro bias at the lidar barycentre [%]",
              100.0 * boresight.gyro_bias.at_barycentre, {"x", "y", "z"});
  fmt::print(
      "over the flight: accelerometer bias max {:.1f} rms {:.1f}, gyro bias max {:.1f} rms {:.1f} "
      "[%]\n",
      100.0 * boresight.accel_bias.max_abs, 100.0 * boresight.accel_bias.rms,
      100.0 * boresight.gyro_bias.max_abs, 100.0 * boresight.gyro_bias.rms);
  const AdjustmentFigures& figures = flight_run.trajectory.figures;
  fmt::print(
      "adjustment: sigma0 {:.4f}, chi2 {:.1f} with redundancy {}, condition number {:.1f}, {} "
      "iterations\n",
      figures.sigma0, figures.chi2, figures.redundancy, boresight.condition_number,
      figures.iterations);
  fmt::print(
      "  {} nodes, {} parameters, {} inertial and {} GNSS epochs, {} pairs kept, {} rejected\n",
      figures.nodes, figures.parameters, figures.imu_epochs, figures.gnss_epochs,
      figures.correspondences, figures.outliers);
  fmt::print("  mean distance of the pairs {:.3f} m before, {:.3f} m after\n",
             flight_run.adjustment.residual_initial_m, flight_run.adjustment.residual_final_m);
  fmt::print("assessment: {}", boresight.verdict);
  for (const std::string& reason : boresight.reasons) fmt::print("; {}", reason);
  fmt::print("\ntime: reading {:.2f} s, solving {:.2f} s, covariances {:.2f} s\n",
             flight_run.timings.read_s, flight_run.timings.solve_s,
             flight_run.timings.covariance_s);
}

void Calibrate(const CalibrateOptions& options, Run& run) {
  if (options.method != "dn") {
    throw InvalidConfig("--method " + options.method +
                        " is not part of this version; use --method dn");
  }
  const std::unique_ptr<FlightRun> flight_run = AdjustFlight(options.flight, true, &run);
  const BoresightResult boresight =
      ExtractBoresight(flight_run->adjustment, *flight_run->marginals);
  const std::vector<UnknownEstimate> unknowns =
      ExtractUnknowns(flight_run->adjustment, *flight_run->marginals);
  AddTrajectoryFiles(*flight_run, &run);
  run.AddFile("result.json",
              FormatJson(CalibrationJson(flight_run->flight.config.name, flight_run->adjustment,
                                         flight_run->trajectory, boresight, unknowns,
                                         flight_run->timings)));
  FillReport(*flight_run, &run);
  PrintResult(*flight_run, boresight, unknowns);
  if (boresight.verdict == "not_observable") {
    throw FailedWithResults("not_observable", fmt::format("the boresight is not observable: {}",
                                                          fmt::join(boresight.reasons, "; ")));
  }
}

}  // namespace

void AddCalibrate(CLI::App* program, Action* action) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* app = program->add_subcommand(
      "calibrate", "Boresight (and what `estimate` names) from raw inertial, GNSS and lidar data");
  app->add_option("FLIGHT", options->flight, "Flight folder")->required();
  app->add_option("--method", options->method, "Formulation")
      ->check(CLI::IsMember({"dn", "gh", "planes", "all"}))
      ->capture_default_str();
  AddCommonOptions(app, &options->common, true);
  app->footer("Example: dn calibrate flight --method dn --out result");
  app->callback([options, action] {
    *action = [options] {
      return Execute("calibrate", options->common, [&](Run& run) { Calibrate(*options, run); });
    };
  });
}

}  // namespace dn::apps
