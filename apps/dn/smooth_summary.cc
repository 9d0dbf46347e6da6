#include "smooth_summary.h"

#include <dn/adjustment/achieved_accuracy.h>
#include <dn/adjustment/words.h>
#include <fmt/format.h>

#include <string>

namespace dn::apps {
namespace {

std::string Triple(const Eigen::Vector3d& values) {
  return fmt::format("{:.4f}, {:.4f}, {:.4f}", values.x(), values.y(), values.z());
}

/// Two statistics of position and attitude with their labels, e.g. "median" and "largest".
struct Figures {
  const char *one, *other;
  Eigen::Vector3d one_enu_m, other_enu_m, one_rph_rad, other_rph_rad;
};

void PrintFigures(const Figures& figures) {
  const auto print = [&](const char* name, const char* unit, const Eigen::Vector3d& one,
                         const Eigen::Vector3d& other) {
    fmt::print("  {:<26} {} {}; {} {} {}\n", name, figures.one, Triple(one), figures.other,
               Triple(other), unit);
  };
  print("position east, north, up", "m", figures.one_enu_m, figures.other_enu_m);
  print("roll, pitch, heading", "deg", figures.one_rph_rad * kDegPerRad,
        figures.other_rph_rad * kDegPerRad);
}

void PrintAccuracy(const std::vector<TrajectorySigma>& sigma, bool contradicted) {
  if (sigma.empty()) return;
  const AchievedAccuracy accuracy = SummariseAccuracy(sigma);
  fmt::print("accuracy, sigmas of the adjustment{}\n",
             contradicted ? ", which the data contradict" : "");
  PrintFigures({"median", "largest", accuracy.median.position_enu_m,
                accuracy.largest.position_enu_m, accuracy.median.rph_rad,
                accuracy.largest.rph_rad});
}

void PrintSeparation(const FilterSeparation& separation) {
  if (separation.epochs.empty()) {
    fmt::print(
        "forward/reverse separation: not available; the two filters never know the heading at the "
        "same time\n");
    return;
  }
  const SeparationAt rms = separation.Rms(), max = separation.Max();
  fmt::print("forward/reverse separation at {} GNSS epochs after alignment\n",
             separation.epochs.size());
  PrintFigures(
      {"rms", "largest", rms.position_enu_m, max.position_enu_m, rms.rph_rad, max.rph_rad});
}

void PrintReference(const Json& errors) {
  if (errors.is_null()) return;
  fmt::print("differences from the reference at {} nodes, rms\n", errors["nodes"].get<long>());
  const auto print = [&](const char* name, const char* unit, const char* key) {
    const Json& values = errors[key];
    if (!values.is_array()) return;
    const Eigen::Vector3d rms(values[0].get<double>(), values[1].get<double>(),
                              values[2].get<double>());
    fmt::print("  {:<26} {} {}\n", name, Triple(rms), unit);
  };
  print("position east, north, up", "m", "position_enu_rmse_m");
  print("velocity east, north, up", "m/s", "velocity_enu_rmse_mps");
  print("roll, pitch, heading", "deg", "roll_pitch_heading_rmse_deg");
}

void PrintStatistics(const std::string& title, const std::vector<SeriesStatistics>& statistics) {
  if (statistics.empty()) return;
  fmt::print("{}\n  {:<18} {:<12} {:>8} {:>8} {:>9} {:>9} {:>7} {:>8} {:>12}\n", title, "sensor",
             "axis", "count", "mean", "variance", "expected", "lag-1", "worst", "at [s]");
  for (const SeriesStatistics& s : statistics) {
    fmt::print("  {:<18} {:<12} {:>8} {:>8.3f} {:>9.3f} {:>9.3f} {:>7.3f} {:>8.2f} {:>12.3f}\n",
               s.sensor, s.axis, s.count, s.mean, s.variance, s.expected_variance,
               s.lag1_correlation, s.worst, s.worst_t_s);
  }
}

}  // namespace

void PrintSmoothSummary(const FlightRun& flight_run, const FilterSeparation& separation,
                        const Json& reference_errors) {
  const TrajectoryResult& trajectory = flight_run.solution->trajectory();
  const ModelCheck& check = flight_run.solution->model_check();
  const AdjustmentFigures& figures = trajectory.figures;
  fmt::print("flight {}: {}\n", flight_run.flight.config.name,
             check.contradicted() ? "contradicted, the data do not agree with the assumed model"
                                  : "consistent, the data agree with the assumed model");
  PrintReasons(Words(check.findings), "smooth.json");
  PrintAccuracy(flight_run.solution->CheckedSigmas(), check.contradicted());
  PrintSeparation(separation);
  PrintClocks(check.clocks);
  PrintReference(reference_errors);
  fmt::print("{} nodes, {} inertial and {} GNSS epochs, alignment {}\n", figures.nodes,
             figures.imu_epochs, figures.gnss_epochs, flight_run.adjustment().alignment_method);
  fmt::print("converged in {} iterations, sigma0 {:.3f}, chi2 {:.1f} with redundancy {}\n",
             figures.iterations, figures.sigma0, figures.chi2, figures.redundancy);
  PrintStatistics("innovations of the forward filter (expected mean 0, variance 1, NIS 1)",
                  trajectory.innovations);
  PrintStatistics("residuals after the adjustment", trajectory.residuals);
}

}  // namespace dn::apps
