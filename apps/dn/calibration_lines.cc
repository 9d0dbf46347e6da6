#include "calibration_lines.h"

#include <dn/adjustment/words.h>
#include <dn/axis_names.h>
#include <dn/diagnosis/control_output.h>
#include <dn/files/truth.h>
#include <dn/report/value_words.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noise_output.h"

namespace dn::apps {
namespace {

void PrintMatrix(const std::string& title, const Eigen::Matrix3d& percent,
                 const char* const (&columns)[3]) {
  fmt::print("{}\n  {:<6} {:>8} {:>8} {:>8}\n", title, "", columns[0], columns[1], columns[2]);
  for (int r = 0; r < 3; ++r) {
    fmt::print("  {:<6} {:>8.1f} {:>8.1f} {:>8.1f}\n", kRollPitchYaw[r], percent(r, 0),
               percent(r, 1), percent(r, 2));
  }
}

void PrintAngles(const FlightConfig& config, const BoresightResult& boresight,
                 const std::string& method) {
  const auto truth_deg = ReadTrueBoresightDeg(config.folder, config.lidar->name);
  const Eigen::Vector3d angles_deg = boresight.angles_rad * kDegPerRad;
  const Eigen::Vector3d sigma_deg = boresight.sigma_rad() * kDegPerRad;
  fmt::print("boresight of flight {}{} [deg], rotation vector about the body axes\n", config.name,
             method);
  fmt::print("  {:<6} {:>12} {:>12}{}\n", "", "estimate", "sigma",
             truth_deg ? fmt::format(" {:>12} {:>10}", "truth", "error/sigma") : "");
  for (int i = 0; i < 3; ++i) {
    fmt::print("  {:<6} {:>12.6f} {:>12.6f}", kRollPitchYaw[i], angles_deg[i], sigma_deg[i]);
    if (truth_deg) {
      fmt::print(" {:>12.6f} {:>10.2f}", (*truth_deg)[i],
                 (angles_deg[i] - (*truth_deg)[i]) / sigma_deg[i]);
    }
    fmt::print("\n");
  }
}

void PrintAssessment(const BoresightResult& boresight) {
  const std::vector<std::string> reasons = Words(boresight.reasons);
  if (boresight.verdict == Verdict::kContradicted) {
    fmt::print("assessment: {}\n", Word(boresight.verdict));
    PrintReasons(reasons, "result.json");
    return;
  }
  fmt::print("assessment: {}", Word(boresight.verdict));
  for (const std::string& reason : reasons) fmt::print("; {}", reason);
  fmt::print("\n");
}

/// Prints the effects that may be present without being detected.
void PrintUndetectable(const std::vector<UndetectableEffect>& undetectable) {
  constexpr std::size_t kMaxPrinted = 3;
  if (undetectable.empty()) return;
  fmt::print("effects not detectable at their typical size (dn gap lists more):\n");
  for (std::size_t k = 0; k < std::min(kMaxPrinted, undetectable.size()); ++k) {
    const UndetectableEffect& one = undetectable[k];
    const std::string shows = std::isfinite(one.minimal_detectable)
                                  ? fmt::format("detectable from {:.2g}", one.minimal_detectable)
                                  : "never detectable";
    fmt::print("  {}{}{}, {:.2g} {}: would move the boresight by {:.1f} sigma, {}\n", one.name,
               one.component.empty() ? "" : " ", one.component, one.usual, one.unit,
               one.max_shift_sigmas, shows);
  }
}

void PrintTimes(const RunTimings& timings) {
  fmt::print("time: reading {:.2f} s, solving {:.2f} s, covariances {:.2f} s\n", timings.read_s,
             timings.solve_s, timings.covariance_s);
}

void PrintUnknowns(const std::vector<UnknownEstimate>& unknowns) {
  for (const UnknownEstimate& unknown : unknowns) {
    fmt::print("{} [{}], correction to the assumed value:", unknown.name, unknown.unit);
    for (std::size_t i = 0; i < unknown.value.size(); ++i) {
      fmt::print(" {}", FormatWithSigma(unknown.value[i], unknown.sigma[i]));
    }
    fmt::print("\n");
  }
}

/// Prints the sigmas of a method on a fixed trajectory, by source.
void PrintSigmas(const BoresightResult& boresight, const CorrelatedErrorCovariance& scatter,
                 const Eigen::Matrix3d& constant_rad2) {
  const auto print_sigmas = [](const char* title, const Eigen::Vector3d& rad) {
    fmt::print("  {:<43} {:>10.6f} {:>10.6f} {:>10.6f}\n", title, rad.x() * kDegPerRad,
               rad.y() * kDegPerRad, rad.z() * kDegPerRad);
  };
  fmt::print("sigmas by source [deg]\n");
  print_sigmas("normal matrix", *boresight.sigma_apriori_rad);
  print_sigmas("normal matrix, times sigma0", *boresight.sigma_scaled_rad);
  print_sigmas("time-correlated trajectory errors", scatter.covariance_rad2.diagonal().cwiseSqrt());
  if (constant_rad2.isZero(0.0)) {
    fmt::print("  {:<43} included in the line above\n", "attitude error constant over the flight");
  } else {
    print_sigmas("attitude error constant over the flight", constant_rad2.diagonal().cwiseSqrt());
  }
  PrintMatrix("correlation of the angles [%]", 100.0 * boresight.correlation(), kRollPitchYaw);
}

void PrintFigures(const AdjustmentFigures& figures, const BoresightResult& boresight) {
  fmt::print(
      "adjustment: sigma0 {:.4f}, chi2 {:.1f} with redundancy {}, condition number {:.1f}, {} "
      "iterations\n",
      figures.sigma0, figures.chi2, figures.redundancy, boresight.condition_number,
      figures.iterations);
}

}  // namespace

void PrintNetwork(const FlightRun& flight_run, const BoresightResult& boresight,
                  const std::vector<UnknownEstimate>& unknowns) {
  PrintAngles(flight_run.flight.config, boresight, "");
  PrintUnknowns(unknowns);
  PrintMatrix("correlation of the angles [%]", 100.0 * boresight.correlation(), kRollPitchYaw);
  PrintMatrix("with the accelerometer bias at the lidar barycentre [%]",
              100.0 * boresight.accel_bias.at_barycentre, kXyz);
  PrintMatrix("with the gyro bias at the lidar barycentre [%]",
              100.0 * boresight.gyro_bias.at_barycentre, kXyz);
  fmt::print(
      "over the flight: accelerometer bias max {:.1f} rms {:.1f}, gyro bias max {:.1f} rms {:.1f} "
      "[%]\n",
      100.0 * boresight.accel_bias.max_abs, 100.0 * boresight.accel_bias.rms,
      100.0 * boresight.gyro_bias.max_abs, 100.0 * boresight.gyro_bias.rms);
  const AdjustmentFigures& figures = flight_run.solution->trajectory().figures;
  fmt::print(
      "adjustment: sigma0 {:.4f}, chi2 {:.1f} with redundancy {}, condition number {:.1f}, {} "
      "iterations\n",
      figures.sigma0, figures.chi2, figures.redundancy, boresight.condition_number,
      figures.iterations);
  fmt::print(
      "  {} nodes, {} parameters, {} inertial and {} GNSS epochs, {} pairs kept, {} rejected\n",
      figures.nodes, figures.parameters, figures.imu_epochs, figures.gnss_epochs,
      figures.correspondences, figures.outliers);
  if (figures.surface_pairs + figures.surface_outliers > 0) {
    fmt::print("  {} surface pairs kept, {} rejected\n", figures.surface_pairs,
               figures.surface_outliers);
  }
  fmt::print("  mean distance of the pairs {:.3f} m before, {:.3f} m after\n",
             flight_run.adjustment().residual_initial_m, flight_run.adjustment().residual_final_m);
  if (const auto& control = flight_run.solution->model_check().control) {
    fmt::print("{}", ControlSummary(*control));
  }
  PrintClocks(flight_run.solution->model_check().clocks);
  PrintNoise(flight_run.noise);
  PrintAssessment(boresight);
  fmt::print("{}", ContributionsSummary(boresight));
  PrintUndetectable(flight_run.solution->model_check().undetectable);
  PrintTimes(flight_run.timings);
}

void PrintGaussHelmert(const FlightConfig& config, const GaussHelmertCalibration& calibration,
                       const RunTimings& timings) {
  const BoresightResult& boresight = calibration.boresight;
  PrintAngles(config, boresight, " by the Gauss-Helmert adjustment");
  PrintSigmas(boresight, calibration.scatter, calibration.constant_rad2);
  const AdjustmentFigures& figures = calibration.figures;
  PrintFigures(figures, boresight);
  fmt::print("  {} pairs kept, {} outliers, rotation {}{}\n", figures.correspondences,
             figures.outliers,
             calibration.options.model == BoresightModel::kExponential ? "exp" : "small_angle",
             calibration.options.libor_compat ? ", libor_compat" : "");
  fmt::print("  mean distance of the pairs {:.3f} m before, {:.3f} m after\n",
             calibration.adjustment.residual_initial_m, calibration.adjustment.residual_final_m);
  PrintAssessment(boresight);
  fmt::print("{}", ContributionsSummary(boresight));
  PrintTimes(timings);
}

void PrintPlaneRun(const FlightConfig& config, const PlaneRun& planes) {
  const PlaneCalibration& calibration = planes.calibration;
  const BoresightResult& boresight = calibration.boresight;
  PrintAngles(config, boresight, " by planes");
  PrintUnknowns(calibration.unknowns);
  PrintSigmas(boresight, calibration.scatter.trajectory, calibration.constant_rad2);
  PrintFigures(calibration.figures, boresight);
  PrintPlanes(planes);
  PrintAssessment(boresight);
  PrintTimes(planes.timings);
}

void PrintDifference(const char* names, const MethodDifference& difference) {
  const Eigen::Vector3d d = difference.difference_rad * kDegPerRad;
  const Eigen::Vector3d sigma = difference.sigma_rad() * kDegPerRad;
  fmt::print("{} [deg]: {:.6f} {:.6f} {:.6f}, sigma {:.6f} {:.6f} {:.6f}, p = {:.3g}\n", names,
             d.x(), d.y(), d.z(), sigma.x(), sigma.y(), sigma.z(), difference.p_value);
}

}  // namespace dn::apps
