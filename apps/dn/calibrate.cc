#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/map_layers.h>
#include <dn/adjustment/swaths.h>
#include <dn/adjustment/words.h>
#include <dn/diagnosis/beams_output.h>
#include <dn/files/pair_clock.h>
#include <dn/files/scanners.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibrate_flights.h"
#include "calibrate_planes.h"
#include "calibrate_strips.h"
#include "calibrated_strips.h"
#include "calibration_lines.h"
#include "flight_identity.h"
#include "flight_run.h"
#include "given_trajectory.h"
#include "new_strips.h"
#include "noise_output.h"
#include "option_checks.h"
#include "swath_files.h"
#include "trajectory_hints.h"

namespace dn::apps {
namespace {

constexpr const char* kTheBoresight = "the boresight";

struct CalibrateOptions {
  CommonOptions common;
  std::vector<std::string> flights;
  std::string flight;  ///< the first one
  std::string method;  ///< empty: chosen from the available data
  std::string trajectory;
  bool georef = false;  ///< also georeferences the strips with the result
  FleetOptions fleet;   ///< for several flights
};

struct Methods {
  bool dn = false;
  bool gh = false;
  bool planes = false;

  bool all() const { return dn && gh && planes; }
};

Methods ChooseMethods(const CalibrateOptions& options, const FlightConfig& config) {
  if (options.method == "all") return {true, true, true};
  if (options.method == "planes") return {.planes = true};
  const bool dn = options.method.empty() ? config.imu.has_value() : options.method == "dn";
  if (dn && !options.trajectory.empty()) {
    throw InvalidConfig(
        "--trajectory is for the methods on a fixed trajectory: add --method gh, --method planes "
        "or --method all");
  }
  return {.dn = dn, .gh = !dn};
}

/// Throws if the trajectory that a method needs does not exist. The message says how to get one.
void ExpectTrajectory(const CalibrateOptions& options, const FlightConfig& config,
                      const char* method) {
  if (HasTrajectory(config)) return;
  const std::string name = config.trajectory ? config.trajectory->file : TrajectoryConfig().file;
  if (!config.imu) {
    throw InvalidConfig(
        "the flight has neither a section 'imu' (for the dynamic network) nor the "
        "trajectory " +
        name + " (for " + method + "); give one with --trajectory FILE");
  }
  throw InvalidInput(
      fmt::format("the trajectory {} does not exist, and {} needs one; make it with "
                  "`dn smooth {} --out DIR` and give it with --trajectory DIR/trajectory.out",
                  name, method, QuoteForShell(options.flight)));
}

struct GaussHelmertRun {
  GaussHelmertCalibration calibration;
  ModelCheck check;
  RunTimings timings;
};

GaussHelmertRun CalibrateByGaussHelmert(const Flight& flight, double read_s, Run* run) {
  GaussHelmertFlightOptions options;
  options.threads = run->options().threads;
  options.progress = [run](const std::string& stage) { run->progress().Stage(stage); };
  options.interrupted = [] { return apps::SignalReceived(); };
  GaussHelmertRun out{CalibrateGaussHelmert(flight, options), {}, {}};
  out.check = AssessModel(flight, &out.calibration);
  out.timings.read_s = read_s;
  out.timings.solve_s = out.calibration.solve_time_s;
  out.timings.covariance_s = out.calibration.covariance_time_s;
  out.timings.total_s = read_s + out.timings.solve_s + out.timings.covariance_s;
  return out;
}

void FillReport(const Flight& flight, const GaussHelmertRun& gauss_helmert, Run* run) {
  Json& report = run->report();
  report["flight"] = flight.config.name;
  report["seed"] = flight.config.lidar->pairs.seed;
  report["counts"] = flight.counts;
  report["counts"]["pairs rejected as outliers"] = gauss_helmert.calibration.adjustment.outliers;
  report["gauss_helmert"] = GaussHelmertReportJson(gauss_helmert.calibration);
  report["timings_s"] = {{"read", gauss_helmert.timings.read_s},
                         {"solve", gauss_helmert.timings.solve_s},
                         {"covariance", gauss_helmert.timings.covariance_s}};
}

/// A boresight with what a message calls it.
struct NamedBoresight {
  std::string name;
  const BoresightResult* boresight;
};

void FailUnlessReliable(const std::vector<NamedBoresight>& results) {
  for (const auto& [name, boresight] : results) {
    if (boresight->verdict == Verdict::kContradicted) {
      ThrowContradicted(Words(boresight->reasons.front()), "the result file");
    }
    if (boresight->verdict != Verdict::kNotObservable) continue;
    throw FailedWithResults(
        Word(boresight->verdict),
        fmt::format("{} is not observable: {}", name, fmt::join(Words(boresight->reasons), "; ")));
  }
}

bool IsUsable(Verdict verdict) {
  return verdict == Verdict::kCalibrated || verdict == Verdict::kAbsorbed;
}

/// Returns which of several methods to use, by the verdict of the dynamic network.
std::string WhichMethod(Verdict network) {
  if (IsUsable(network)) {
    return "use the angles of dn (result.json): it uses all data; the other methods are checks of "
           "it";
  }
  return fmt::format(
      "use the angles of no method: dn uses all data, and its boresight is {}; the other methods "
      "use a part of the same data, and cannot see what is wrong. Mend what the reasons of dn "
      "name, and calibrate again",
      network == Verdict::kContradicted ? "contradicted" : "not observable");
}

/// A flight adjusted by the dynamic network, with the calibration results.
struct NetworkRun {
  std::unique_ptr<FlightRun> flight_run;
  BoresightResult boresight;
  std::vector<UnknownEstimate> unknowns;
  PoseInterpolator poses;  ///< poses of the adjusted trajectory
  std::vector<PairResidual> pairs;
  ScannerMountings mountings;          ///< of several scanners
  std::vector<BeamCorrections> beams;  ///< of scanners with several beams

  /// Returns the boresights of all scanners, and that of the result.
  std::vector<NamedBoresight> Boresights() const {
    std::vector<NamedBoresight> all;
    for (const ScannerBoresight& scanner : mountings.scanners) {
      all.push_back({"the boresight of scanner " + scanner.name, &scanner.boresight});
    }
    all.push_back({kTheBoresight, &boresight});
    return all;
  }

  BoresightByScanner ByScanner() const {
    if (mountings.scanners.empty()) {
      return {{flight_run->flight.config.lidar->name, &boresight}};
    }
    BoresightByScanner all;
    for (const ScannerBoresight& scanner : mountings.scanners) {
      all.emplace(scanner.name, &scanner.boresight);
    }
    return all;
  }
};

NetworkRun CalibrateByNetwork(std::unique_ptr<FlightRun> flight_run) {
  const Solution& solution = *flight_run->solution;
  PoseInterpolator poses(
      Trajectory(std::move(flight_run->modelled)).ToMapPoses(flight_run->flight.frame));
  std::vector<PairResidual> pairs = PairResiduals(solution.network(), poses);
  NetworkRun out{
      nullptr,          solution.CheckedBoresight(), solution.CheckedUnknowns(), std::move(poses),
      std::move(pairs), solution.CheckedMountings(), solution.CheckedBeams()};
  out.flight_run = std::move(flight_run);
  return out;
}

/// Stages the swaths of the pairs, unless swaths of matched point clouds are staged: those show
/// more.
void AddSwaths(const Flight& flight, const std::vector<PairResidual>& pairs,
               const PoseInterpolator& poses, Run* run) {
  if (HasSwathFiles(*run)) return;
  AddSwathFiles(MakeSwaths(FindStrips(flight), pairs, poses), flight.frame, run);
}

void AddPairFiles(const Flight& flight, const std::vector<PairResidual>& pairs,
                  const std::string& suffix, Run* run) {
  run->AddFile("pair_residuals" + suffix + ".txt", FormatPairResiduals(pairs));
  run->AddFile("pairs" + suffix + ".geojson", FormatPairLayer(pairs, flight.frame));
}

/// Stages the control points with their residuals, if the flight has control.
void AddControlLayer(const FlightRun& flight_run, Run* run) {
  const Flight& flight = flight_run.flight;
  const auto& check = flight_run.solution->model_check().control;
  if (!check || !flight.control) return;
  run->AddFile("control.geojson", FormatControlLayer(*check, *flight.control, flight.frame));
}

/// Returns the text of a result. That of one scanner of a list has its name.
std::string ResultText(const FlightConfig& config, Json json) {
  const bool one = NumScanners(config) == 1 && !config.lidar->name.empty();
  if (one) json["scanner"] = config.lidar->name;
  return FormatJson(json);
}

/// Stages the files of the dynamic network. suffix: distinguishes the methods of a run.
void AddNetworkFiles(const NetworkRun& network, const CalibrateOptions& options,
                     const std::string& suffix, Run* run) {
  const FlightRun& flight_run = *network.flight_run;
  AddTrajectoryFiles(flight_run, run);
  AddSwaths(flight_run.flight, network.pairs, network.poses, run);
  AddPairFiles(flight_run.flight, network.pairs, suffix, run);
  AddControlLayer(flight_run, run);
  Json json =
      CalibrationJson(flight_run.flight.config.name, flight_run.adjustment(),
                      flight_run.solution->trajectory(), flight_run.solution->model_check(),
                      network.boresight, network.unknowns, network.pairs, flight_run.timings);
  AddScannersJson(network.mountings, &json);
  AddBeamsJson(network.beams, true, &json);
  if (flight_run.noise) AddNoise(*flight_run.noise, &json);
  const std::string result = ResultText(flight_run.flight.config, std::move(json));
  run->AddFile("result" + suffix + ".json", result);
  if (!suffix.empty()) run->AddFile("result.json", result);  // the one to use
  if (!network.mountings.scanners.empty()) return FillReport(flight_run, run);
  ReducedFlight reduced = ReduceFlight(*flight_run.solution, network.boresight);
  SetIdentity(ReadFlightConfig(options.flight, options.common.changes), options.common.changes,
              &reduced);
  run->AddFile("reduced.json", FormatJson(ReducedFlightJson(reduced)));
  FillReport(flight_run, run);
}

void RunNetwork(const CalibrateOptions& options, const FlightConfig& config, Run& run) {
  const NetworkRun network = CalibrateByNetwork(AdjustFlight(config, true, &run));
  AddNetworkFiles(network, options, "", &run);
  PrintNetwork(*network.flight_run, network.boresight, network.unknowns);
  fmt::print("{}", ScannersSummary(network.mountings));
  fmt::print("{}", BeamsSummary(network.beams, true));
  if (options.georef) {
    AddNewStrips(network.flight_run->flight.config, network.ByScanner(), network.beams,
                 &network.flight_run->trajectory, &run);
  }
  FailUnlessReliable(network.Boresights());
}

/// Reads a flight whose pairs must agree on its trajectory. If they do not, the message names what
/// the GNSS and inertial data show to be wrong with the trajectory, if anything. Otherwise this is
/// a warning.
Flight ReadOnTrajectory(const FlightConfig& config, const FlightNeeds& needs, Run* run) {
  const std::vector<DataHint> hints = TrajectoryHints(config);
  try {
    Flight flight = ReadFlight(config, needs);
    ExpectPairClock(flight);
    for (const DataHint& hint : hints) run->progress().Warn(HintText(hint));
    return flight;
  } catch (const InvalidInput&) {
    if (hints.empty()) throw;
    throw InvalidInput(HintText(hints.front()),
                       {config.trajectory.value_or(TrajectoryConfig()).file});
  }
}

Flight ReadForGaussHelmert(const FlightConfig& config, bool with_network, double* read_s,
                           Run* run) {
  run->progress().Stage("reading " + config.folder.string());
  FlightNeeds needs;
  needs.pairs = needs.trajectory = true;
  needs.imu = needs.gnss = needs.control = needs.ties = with_network;
  Flight flight = ReadOnTrajectory(config, needs, run);
  *read_s = flight.read_time_s;
  return flight;
}

void AddGaussHelmertFiles(const Flight& flight, const GaussHelmertRun& gh,
                          const std::string& suffix, Run* run) {
  const std::vector<PairResidual> pairs = PairResiduals(flight, gh.calibration);
  AddSwaths(flight, pairs, PoseInterpolator(flight.trajectory->ToMapPoses(flight.frame)), run);
  AddPairFiles(flight, pairs, suffix, run);
  Json json = CalibrationJson(flight.config.name, gh.calibration, gh.check, pairs, gh.timings);
  AddBeamsJson(gh.calibration.beams, true, &json);
  run->AddFile("result" + suffix + ".json", ResultText(flight.config, std::move(json)));
}

/// Says that a method on a fixed trajectory does not use the control of the flight.
void WarnAboutControl(const FlightConfig& config, Run* run) {
  if (!HasControl(config)) return;
  const char* const kText =
      "the control of the flight is not used: only the dynamic network (--method dn) estimates "
      "with control points and predicts checks";
  run->progress().Warn(kText);
  run->report()["notes"] = {kText};
}

void RunGaussHelmert(const CalibrateOptions& options, const FlightConfig& config, Run& run) {
  double read_s = 0.0;
  const Flight flight = ReadForGaussHelmert(config, false, &read_s, &run);
  WarnAboutControl(config, &run);
  const GaussHelmertRun gh = CalibrateByGaussHelmert(flight, read_s, &run);
  AddGaussHelmertFiles(flight, gh, "", &run);
  run.AddFile("config.resolved.yaml", FormatFlightConfig(flight.config));
  FillReport(flight, gh, &run);
  PrintGaussHelmert(flight.config, gh.calibration, gh.timings);
  fmt::print("{}", BeamsSummary(gh.calibration.beams, true));
  if (options.georef) {
    AddNewStrips(flight.config, {{flight.config.lidar->name, &gh.calibration.boresight}},
                 gh.calibration.beams, nullptr, &run);
  }
  FailUnlessReliable({{kTheBoresight, &gh.calibration.boresight}});
}

PlaneRun CalibrateByPlanes(const CalibrateOptions& options, const Flight& flight, Run* run) {
  const FlightConfig own = ReadFlightConfig(options.flight, options.common.changes);
  // If the flight has no trajectory, the one smoothed for matching is used.
  const std::string& trajectory =
      HasTrajectory(own) ? options.trajectory : flight.config.trajectory->file;
  return CalibrateByPlanes(flight, own, trajectory, run);
}

void AddPlaneFiles(const FlightConfig& config, const PlaneRun& planes, const std::string& suffix,
                   Run* run) {
  Json json =
      CalibrationJson(config.name, planes.calibration, planes.check, planes.strips, planes.timings);
  AddBeamsJson(planes.calibration.beams, true, &json);
  run->AddFile("result" + suffix + ".json", ResultText(config, std::move(json)));
  run->report()["planes"] = PlaneReportJson(planes);
}

void RunPlanes(const CalibrateOptions& options, const FlightConfig& config, Run& run) {
  const std::string reason = WhyNoPlanes(config);
  if (!reason.empty()) {
    throw InvalidInput(reason + ", and --method planes needs point clouds in " +
                       (config.folder / "strips").string());
  }
  run.progress().Stage("reading " + config.folder.string());
  const Flight flight = ReadFlight(config, {.trajectory = true});
  run.report()["flight"] = config.name;
  WarnAboutControl(config, &run);
  const PlaneRun planes = CalibrateByPlanes(options, flight, &run);
  AddPlaneFiles(config, planes, "", &run);
  run.AddFile("config.resolved.yaml", FormatFlightConfig(flight.config));
  run.report()["counts"] = flight.counts;
  run.report()["timings_s"] = {{"read", planes.timings.read_s},
                               {"solve", planes.timings.solve_s},
                               {"covariance", planes.timings.covariance_s}};
  PrintPlaneRun(flight.config, planes);
  fmt::print("{}", BeamsSummary(planes.calibration.beams, true));
  if (options.georef) {
    AddNewStrips(flight.config, {{flight.config.lidar->name, &planes.calibration.boresight}},
                 planes.calibration.beams, nullptr, &run);
  }
  FailUnlessReliable({{kTheBoresight, &planes.calibration.boresight}});
}

/// Plane calibration as part of --method all; `missing` says why there is no result.
struct OptionalPlanes {
  std::optional<PlaneRun> run;
  std::string missing;
};

OptionalPlanes TryPlanes(const CalibrateOptions& options, const Flight& flight, Run* run) {
  OptionalPlanes out;
  out.missing = WhyNoPlanes(flight.config);
  if (!out.missing.empty()) return out;
  try {
    out.run = CalibrateByPlanes(options, flight, run);
  } catch (const RankDeficient& finding) {
    out.missing = finding.what();
  } catch (const NotConverged& finding) {
    out.missing = finding.what();
  }
  return out;
}

void PrintPlanesOrReason(const FlightConfig& config, const OptionalPlanes& planes,
                         const BoresightResult& network) {
  if (!planes.run) {
    fmt::print("planes: no result: {}\n", planes.missing);
    return;
  }
  PrintPlaneRun(config, *planes.run);
  PrintDifference("planes - dn", CompareIndependent(planes.run->calibration.boresight, network));
}

void RunAll(const CalibrateOptions& options, const FlightConfig& config, Run& run) {
  double read_s = 0.0;
  Flight flight = ReadForGaussHelmert(config, true, &read_s, &run);
  GaussHelmertRun gh = CalibrateByGaussHelmert(flight, read_s, &run);
  const OptionalPlanes planes = TryPlanes(options, flight, &run);
  const NetworkRun network =
      CalibrateByNetwork(AdjustFlight(std::move(flight), read_s, true, &run));
  AssessAgainstNetwork(network.boresight, &gh.calibration);
  std::vector<NamedBoresight> results{{kTheBoresight, &network.boresight},
                                      {kTheBoresight, &gh.calibration.boresight}};
  std::vector<std::pair<std::string, const BoresightResult*>> methods{
      {"gh", &gh.calibration.boresight}, {"dn", &network.boresight}};
  std::vector<std::pair<std::string, std::string>> absent;
  FillReport(network.flight_run->flight, gh, &run);
  AddNetworkFiles(network, options, "_dn", &run);
  AddGaussHelmertFiles(network.flight_run->flight, gh, "_gh", &run);
  if (planes.run) {
    AddPlaneFiles(config, *planes.run, "_planes", &run);
    results.push_back({kTheBoresight, &planes.run->calibration.boresight});
    methods.emplace_back("planes", results.back().boresight);
  } else {
    absent.emplace_back("planes", planes.missing);
    run.report()["notes"] = {"planes: " + planes.missing};
  }
  Json comparison = ComparisonJson(config.name, methods, absent);
  const bool use_network = IsUsable(network.boresight.verdict);
  comparison["use"] = use_network ? Json("dn") : Json();
  comparison["why"] = WhichMethod(network.boresight.verdict);
  run.AddFile("comparison.json", FormatJson(comparison));
  PrintNetwork(*network.flight_run, network.boresight, network.unknowns);
  fmt::print("{}", BeamsSummary(network.beams, true));
  PrintGaussHelmert(config, gh.calibration, gh.timings);
  PrintDifference("gh - dn", Compare(gh.calibration.boresight, network.boresight));
  PrintPlanesOrReason(config, planes, network.boresight);
  fmt::print("{}\n", WhichMethod(network.boresight.verdict));
  if (options.georef) {
    AddNewStrips(network.flight_run->flight.config, network.ByScanner(), network.beams,
                 &network.flight_run->trajectory, &run);
  }
  FailUnlessReliable(results);
}

void CalibrateBy(const Methods& methods, const CalibrateOptions& options,
                 const FlightConfig& config, Run& run) {
  if (methods.gh) ExpectTrajectory(options, config, "the Gauss-Helmert adjustment");
  if (methods.planes) ExpectTrajectory(options, config, "the plane adjustment");
  if (methods.all()) {
    RunAll(options, config, run);
  } else if (methods.planes) {
    RunPlanes(options, config, run);
  } else if (methods.gh) {
    RunGaussHelmert(options, config, run);
  } else {
    RunNetwork(options, config, run);
  }
}

void CalibrateSeveral(const CalibrateOptions& options, Run& run) {
  const auto refuse = [](bool given, const char* option) {
    if (!given) return;
    throw InvalidConfig(
        std::string("several flights are calibrated by the dynamic network, without ") + option +
        "; leave it out, or give one flight");
  };
  refuse(!options.method.empty() && options.method != "dn", "--method");
  refuse(!options.trajectory.empty(), "--trajectory");
  FleetOptions fleet = options.fleet;
  fleet.georef = options.georef;
  CalibrateFlights(options.flights, options.common.changes, fleet, run);
}

void Calibrate(const CalibrateOptions& options, Run& run) {
  if (options.flights.size() > 1) {
    CalibrateSeveral(options, run);
    return;
  }
  const FleetOptions& fleet = options.fleet;
  if (!fleet.across.empty() || !fleet.between.empty() || fleet.include_uncalibrated) {
    throw InvalidConfig(
        "--across, --between and --include-uncalibrated are for several flights, but there is "
        "one; give the others, too");
  }
  const FlightConfig config =
      WithTrajectory(ReadFlightConfig(options.flight, options.common.changes), options.trajectory);
  const Methods methods = ChooseMethods(options, config);
  if (methods.gh || methods.planes) {
    ExpectOneScanner(config, "--method " + (options.method.empty() ? "gh" : options.method));
  }
  if (options.georef) {
    for (const FlightConfig& scanner : GeoreferenceableScanners(config)) {
      if (methods.dn) ExpectBeamsInStrips(scanner);
    }
  }
  if ((methods.dn || methods.gh) && HasStripsAlone(config)) {
    CalibrateStrips(
        ReadFlightConfig(options.flight, options.common.changes), options.trajectory, run,
        [&](const FlightConfig& matched) { CalibrateBy(methods, options, matched, run); });
  } else if ((methods.gh || (methods.planes && WhyNoPlanes(config).empty())) &&
             !HasTrajectory(config) && !config.trajectory && config.imu && config.gnss) {
    CalibrateSmoothed(config, run, [&](const FlightConfig& smoothed) {
      CalibrateBy(methods, options, smoothed, run);
    });
  } else {
    CalibrateBy(methods, options, config, run);
  }
}

}  // namespace

void AddCalibrate(CLI::App* program, Action* action) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* app = program->add_subcommand("calibrate",
                                          "Estimates the boresight (and the unknowns in "
                                          "`estimate`) from raw inertial, GNSS and lidar data "
                                          "(dn), or from a smoothed trajectory and lidar data "
                                          "(gh, planes)");
  app->add_option("FLIGHT", options->flights,
                  "Flight folder or YAML file of a flight. Several flights: one boresight for all, "
                  "from each flight's own adjustment in --out/<flight>, or from result folders of "
                  "earlier calibrations")
      ->required();
  AddChanges(app, "flight.yaml", "gnss.sigma_scale=2", &options->common);
  AddScanner(app, &options->common);
  AddUnmodelled(app, &options->common);
  AddFleetOptions(app, &options->fleet);
  app->add_option(
         "--method", options->method,
         "dn: dynamic network; gh: Gauss-Helmert adjustment on a fixed trajectory; planes: planes "
         "in overlapping strips on a fixed trajectory; all: all three and their comparison. "
         "Default: dn, or gh if flight.yaml has no inertial data. Strips without pairs are matched "
         "first")
      ->check(AllowedValues({"dn", "gh", "planes", "all"}));
  app->add_option("--trajectory", options->trajectory,
                  "Smoothed trajectory for gh and planes (SBET .out or text). Default: that of "
                  "the flight");
  app->add_flag(
      "--georef", options->georef,
      "Also writes the strips of the flight with the new boresight and, by the dynamic "
      "network, the adjusted trajectory: strips/, as `dn georef` does. Several flights: those "
      "of each flight, with the boresight of all");
  AddCommonOptions(app, &options->common, true);
  app->footer(
      "Example: dn calibrate flight --method gh --trajectory smoothed/trajectory.out --out result");
  app->callback([options, action] {
    options->flight = options->flights.front();
    options->common.resumable = options->flights.size() > 1;
    *action = [options] {
      options->common.inputs =
          options->flights.size() > 1
              ? FleetInputs(options->flights, options->common.changes, options->fleet.between)
              : FlightInputs(options->flight, options->common.changes, options->trajectory);
      return Execute("calibrate", options->common, [&](Run& run) { Calibrate(*options, run); });
    };
  });
}

}  // namespace dn::apps
