#include "flight_run.h"

#include <dn/adjustment/control_search.h>
#include <dn/adjustment/gnss_errors.h>
#include <dn/adjustment/left_out_gnss.h>
#include <dn/adjustment/words.h>
#include <dn/axis_names.h>
#include <dn/diagnosis/reject_control.h>
#include <dn/error.h>
#include <dn/files/pair_clock.h>
#include <dn/parallel.h>
#include <dn/report/plot.h>
#include <dn/report/value_words.h>
#include <dn/stopwatch.h>
#include <fmt/format.h>

#include <algorithm>

#include "data_hints.h"
#include "noise_output.h"

namespace dn::apps {
namespace {

// Spacing of trajectory.out: 100 Hz resolves the motion of all common platforms.
constexpr double kTrajectorySpacingS = 0.01;
// Maximum number of points of a plotted curve; more would not be visible.
constexpr std::size_t kPlotPoints = 2000;

template <class Row, class Get>
PlotSeries Curve(const std::string& label, const std::vector<Row>& rows, const Get& get) {
  PlotSeries series{label, {}};
  const std::size_t step = std::max<std::size_t>(1, rows.size() / kPlotPoints);
  for (std::size_t i = 0; i < rows.size(); i += step) {
    series.points.emplace_back(rows[i].t_s - rows.front().t_s, get(rows[i]));
  }
  return series;
}

struct Plot {
  std::string file;
  std::optional<std::string> svg;  ///< absent if it could not be drawn
};

std::vector<Plot> DrawPlots(const FlightRun& flight_run) {
  const std::vector<TrajectorySigma> sigma = flight_run.solution->CheckedSigmas();
  const auto& biases = flight_run.solution->trajectory().biases;
  std::vector<PlotPanel> panels{{"position sigma [m]", {}}, {"attitude sigma [deg]", {}}};
  std::vector<PlotPanel> bias_panels{{"gyro bias [deg/h]", {}}, {"accelerometer bias [mg]", {}}};
  for (int i = 0; i < 3; ++i) {
    panels[0].series.push_back(
        Curve(kEnu[i], sigma, [i](const TrajectorySigma& row) { return row.position_enu_m[i]; }));
    panels[1].series.push_back(Curve(kAttitudeAngles[i], sigma, [i](const TrajectorySigma& row) {
      return row.rph_rad[i] * kDegPerRad;
    }));
    bias_panels[0].series.push_back(Curve(kXyz[i], biases, [i](const BiasEstimate& row) {
      return row.gyro_radps[i] * kDegPerRad * 3600.0;
    }));
    bias_panels[1].series.push_back(Curve(kXyz[i], biases, [i](const BiasEstimate& row) {
      return row.accel_mps2[i] * 1e3 / kStandardGravityMps2;
    }));
  }
  const std::string name = flight_run.flight.config.name;
  return {{"trajectory_sigma.svg", DrawSvg(name + ": posterior standard deviations",
                                           "time since start [s]", panels, SignalReceived)},
          {"biases.svg", DrawSvg(name + ": inertial biases", "time since start [s]", bias_panels,
                                 SignalReceived)}};
}

void AddPlots(const std::vector<Plot>& plots, Run* run) {
  for (const Plot& plot : plots) {
    if (plot.svg) {
      run->AddFile(plot.file, *plot.svg);
    } else {
      run->progress().Warn(
          "no plots: gnuplot is not installed or failed; the numbers are in the text files");
    }
  }
}

/// Formats the counts, e.g. "3 GNSS positions and 1 GNSS velocity".
std::string RejectedCountsText(const LeftOutGnss& out) {
  const auto count = [](long n, const char* one, const char* many) {
    return fmt::format("{} GNSS {}", n, n == 1 ? one : many);
  };
  std::string velocities = count(out.velocities, "velocity", "velocities");
  if (out.positions == 0) return velocities;
  const std::string positions = count(out.positions, "position", "positions");
  return out.velocities == 0 ? positions : positions + " and " + velocities;
}

/// Returns a warning about control points that are not used; empty if all are.
std::string ControlWarning(const FlightRun& flight_run) {
  const auto& control = flight_run.flight.control;
  const std::vector<ControlNode>& used = flight_run.adjustment().network->control().points();
  if (!control || used.size() == control->points.size()) return {};
  std::vector<const ControlPoint*> unused;
  for (std::size_t k = 0; k < control->points.size(); ++k) {
    const bool found = std::any_of(used.begin(), used.end(),
                                   [&](const ControlNode& node) { return node.point == k; });
    if (!found) unused.push_back(&control->points[k]);
  }
  const char* const kNoCloud =
      "give its laser vector and epoch (t, ux, uy, uz), or put a cloud that covers it into strips/";
  const char* const kNoFacets =
      "a corner needs a cloud with three planes through it, with ten points on each within "
      "control.corner_radius_m";
  return fmt::format("{} of {} control points have no laser return, the first is {}: {}",
                     unused.size(), control->points.size(), unused.front()->name,
                     unused.front()->is_corner ? kNoFacets : kNoCloud);
}

std::vector<std::string> Warnings(const FlightRun& flight_run) {
  std::vector<std::string> warnings = flight_run.hints;
  std::vector<Finding> findings = flight_run.adjustment().warnings;
  const auto& statistics = flight_run.solution->trajectory().warnings;
  findings.insert(findings.end(), statistics.begin(), statistics.end());
  const auto& unmodelled = flight_run.solution->model_check().unmodelled;
  const bool usual = unmodelled && unmodelled->gnss_process_usual.value_or(false);
  const auto warning = GnssErrorWarning(flight_run.adjustment());
  if (warning && !usual) findings.push_back(*warning);
  for (const std::string& text : Words(findings)) warnings.push_back(text);
  if (const std::string text = ControlWarning(flight_run); !text.empty()) warnings.push_back(text);
  const std::vector<std::size_t>& rejected = flight_run.adjustment().gnss_rejected;
  if (!rejected.empty()) {
    const MapGnssEpoch& first = flight_run.flight.gnss->epochs[rejected.front()];
    warnings.push_back(fmt::format(
        "{} contradict all other data and were left out, the first at t = {:.3f} s ({}:{}); "
        "report.json lists their {} epochs",
        RejectedCountsText(CountLeftOutGnss(*flight_run.adjustment().network)), first.t_s,
        flight_run.flight.config.gnss->file, first.line, rejected.size()));
  }
  return warnings;
}

/// Fills the report with the results of reading, so that a failed adjustment keeps them.
void ReportReading(const FlightRun& flight_run, Run* run) {
  run->report()["flight"] = flight_run.flight.config.name;
  run->report()["counts"] = flight_run.flight.counts;
  run->report()["warnings"] = flight_run.hints;
  run->report()["timings_s"]["read"] = flight_run.timings.read_s;
  for (const std::string& hint : flight_run.hints) run->progress().Warn(hint);
}

std::vector<std::string> FormatHints(const Flight& flight, int threads) {
  std::vector<std::string> texts;
  for (const DataHint& hint : DataHints(flight, FindDataAgreement(flight, threads))) {
    texts.push_back(HintText(hint));
  }
  return texts;
}

/// Estimates the noise of the flight if it is unknown, and adjusts the flight. If the sensors
/// contradict each other, the message names a mistake in the axes, or else the hints, instead of
/// the general remedy.
Adjustment AdjustNamingCauses(const AdjustOptions& options, FlightRun* flight_run, Run* run) {
  Flight& flight = flight_run->flight;
  const std::vector<std::string>& hints = flight_run->hints;
  try {
    flight_run->noise = EstimateUnknownNoise(options, &flight, run);
    return Adjust(flight, options);
  } catch (const SensorsContradict& e) {
    const auto axes = FindAxesMistake(flight, options.threads);
    if (axes) throw InvalidInput(e.finding() + HintText(*axes), {flight.config.imu->file});
    if (hints.empty()) throw;
    throw InvalidInput(e.finding() + fmt::format("{}", fmt::join(hints, "; also ")), e.where());
  }
}

/// Throws InvalidInput if the pairs do not agree as tagged. The message names the clock of GNSS if
/// the inertial data show that this one is wrong, else that of the pairs.
void ExpectClocks(const Flight& flight, int threads) {
  if (!FindPairClockOffset(flight)) return;
  for (const DataHint& hint : DataHints(flight, FindDataAgreement(flight, threads))) {
    if (IsClockHint(hint)) throw InvalidInput(HintText(hint), {flight.config.gnss->file});
  }
  ExpectPairClock(flight);
}

Json RejectedGnssJson(const FlightRun& flight_run) {
  Json epochs = Json::array();
  for (const std::size_t e : flight_run.adjustment().gnss_rejected) {
    const MapGnssEpoch& epoch = flight_run.flight.gnss->epochs[e];
    epochs.push_back({{"t_s", epoch.t_s}, {"line", epoch.line}});
  }
  return epochs;
}

}  // namespace

std::unique_ptr<FlightRun> AdjustFlight(const FlightConfig& config, bool with_pairs, Run* run) {
  const Stopwatch watch;
  run->progress().Stage("reading " + config.folder.string());
  FlightNeeds needs;
  needs.imu = true;
  needs.gnss = true;
  needs.pairs = with_pairs;
  needs.control = needs.ties = with_pairs;
  needs.threads = run->options().threads;
  Flight flight = ReadFlight(config, needs);
  ExpectClocks(flight, run->options().threads);
  return AdjustFlight(std::move(flight), watch.seconds(), with_pairs, run);
}

std::unique_ptr<FlightRun> AdjustFlight(Flight flight, double read_s, bool with_pairs, Run* run) {
  auto result = std::make_unique<FlightRun>();
  result->flight = std::move(flight);
  result->timings.read_s = read_s;
  result->hints = FormatHints(result->flight, run->options().threads);
  ReportReading(*result, run);

  const Stopwatch solve_watch;
  AdjustOptions options;
  options.with_pairs = with_pairs;
  options.threads = run->options().threads;
  options.progress = [run](const std::string& stage, int iterations) {
    run->progress().Stage(stage, iterations > 0 ? fmt::format("{} iterations", iterations) : "");
  };
  options.interrupted = [] { return apps::SignalReceived(); };
  Adjustment adjustment = AdjustNamingCauses(options, result.get(), run);
  if (NeedsControlSearch(result->flight)) {
    run->progress().Stage("control in the strips");
    run->ReadsStrips();
    AddControlFromStrips(options, &result->flight, &adjustment);
  }
  result->timings.solve_s = solve_watch.seconds();

  const Stopwatch covariance_watch;
  run->progress().Stage("covariances");
  result->solution.emplace(std::move(adjustment), options.threads).trajectory();
  run->progress().Stage("model check");
  RejectWrongControl(result->flight, options, &result->solution);
  const Solution& solution = *result->solution;
  solution.model_check();
  result->modelled = DenseTrajectory(solution.network(), kTrajectorySpacingS, options.threads);
  result->trajectory = Trajectory(solution.CheckedTrajectory(result->modelled));
  result->timings.covariance_s = covariance_watch.seconds();
  const std::vector<std::string> warnings = Warnings(*result);
  std::for_each(warnings.begin() + static_cast<std::ptrdiff_t>(result->hints.size()),
                warnings.end(),
                [run](const std::string& warning) { run->progress().Warn(warning); });
  result->timings.total_s = read_s + solve_watch.seconds();
  return result;
}

void AddTrajectoryFiles(const FlightRun& flight_run, Run* run) {
  run->progress().Stage("writing " + run->options().out.string());
  const FlightNetwork& network = *flight_run.adjustment().network;
  const bool with_pairs = !network.pairs().edges().empty();
  auto plots = Beside(run->options().threads, [&] { return DrawPlots(flight_run); });
  run->AddFile("trajectory.out", FormatSbet(flight_run.trajectory.points(), with_pairs));
  run->AddFile("trajectory_sigma.txt", FormatTrajectorySigma(flight_run.solution->CheckedSigmas()));
  run->AddFile("biases.txt", FormatBiases(flight_run.solution->CheckedBiases()));
  if (!network.trajectory().gnss_error().empty()) {
    run->AddFile("gnss_errors.txt", FormatGnssErrors(network, flight_run.solution->marginals()));
  }
  run->AddFile("config.resolved.yaml", FormatFlightConfig(flight_run.flight.config));
  AddPlots(plots.get(), run);
}

void FillReport(const FlightRun& flight_run, Run* run) {
  Json& report = run->report();
  report["flight"] = flight_run.flight.config.name;
  if (const auto& lidar = flight_run.flight.config.lidar) report["seed"] = lidar->pairs.seed;
  report["alignment"] = flight_run.adjustment().alignment_method;
  report["node_rate_hz"] = flight_run.adjustment().node_rate_hz;
  report["counts"] = flight_run.flight.counts;
  report["counts"]["pairs rejected as outliers"] = flight_run.adjustment().outliers;
  report["counts"]["pairs within one node"] =
      flight_run.adjustment().network->pairs().within_one_node();
  const auto read_in_gaps = flight_run.flight.counts.find("pairs in IMU gaps");
  report["counts"]["pairs in IMU gaps"] =
      flight_run.adjustment().network->pairs().in_imu_gaps() +
      (read_in_gaps == flight_run.flight.counts.end() ? 0 : read_in_gaps->second);
  const LeftOutGnss out = CountLeftOutGnss(*flight_run.adjustment().network);
  report["counts"]["gnss positions rejected"] = out.positions;
  report["counts"]["gnss velocities rejected"] = out.velocities;
  report["counts"]["gnss epochs rejected"] = flight_run.adjustment().gnss_rejected.size();
  report["gnss_rejected"] = RejectedGnssJson(flight_run);
  report["warnings"] = Warnings(flight_run);
  report["residuals"] = StatisticsToJson(flight_run.solution->trajectory().residuals);
  report["innovations"] = StatisticsToJson(flight_run.solution->trajectory().innovations);
  report["gnss_errors"] = GnssErrorsJson(flight_run.adjustment(), flight_run.solution->marginals());
  report["reference_errors"] =
      ReferenceErrorsJson(flight_run.flight, flight_run.solution->CheckedPoses());
  if (flight_run.noise) AddNoise(*flight_run.noise, &report);
  report["stages"] = Json::array();
  for (const StageSummary& stage : flight_run.adjustment().stages) {
    report["stages"].push_back({{"name", stage.name},
                                {"iterations", stage.iterations},
                                {"cost_before", stage.cost_before},
                                {"cost_after", stage.cost_after},
                                {"converged", stage.converged},
                                {"time_s", stage.time_s}});
  }
  report["timings_s"] = {{"read", flight_run.timings.read_s},
                         {"solve", flight_run.timings.solve_s},
                         {"covariance", flight_run.timings.covariance_s}};
}

void PrintClocks(const Clocks& clocks) {
  const auto print = [](const char* sensor, const std::optional<ClockEstimate>& clock) {
    if (!clock) return;
    const ClockEstimate alone = clock->WithoutDrift();
    fmt::print("  {:<6} offset {} s, drift {} ppm; offset without drift {} s\n", sensor,
               FormatWithSigma(clock->offset_s, clock->sigma_offset_s),
               FormatWithSigma(clock->drift * 1e6, clock->sigma_drift * 1e6),
               FormatWithSigma(alone.offset_s, alone.sigma_offset_s));
  };
  if (!clocks.gnss && !clocks.lidar) return;
  fmt::print(
      "clocks against that of the inertial data, tag = t + offset + drift (t - first epoch)\n");
  print("gnss", clocks.gnss);
  print("lidar", clocks.lidar);
}

void PrintReasons(const std::vector<std::string>& reasons, const std::string& file) {
  constexpr std::size_t kMaxPrinted = 3;
  for (std::size_t k = 0; k < std::min(kMaxPrinted, reasons.size()); ++k) {
    fmt::print("  {}\n", reasons[k]);
  }
  if (reasons.size() <= kMaxPrinted) return;
  fmt::print("  and {} more: {}, report.html\n", reasons.size() - kMaxPrinted, file);
}

void ThrowContradicted(const std::string& first_finding, const std::string& file) {
  throw FailedWithResults(
      "contradicted", fmt::format("the data contradict the assumed model: {}; {} has all findings",
                                  first_finding, file));
}

}  // namespace dn::apps
