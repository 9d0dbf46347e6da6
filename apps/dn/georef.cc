#include <dn/adjustment/swaths.h>
#include <dn/adjustment/words.h>
#include <dn/error.h>
#include <dn/files/accuracy_files.h>
#include <dn/files/flight.h>
#include <dn/files/georeference_strip.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/files/yaml_sections.h>
#include <dn/geo/text_table.h>
#include <dn/interrupted.h>
#include <dn/lidar/beam.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <map>
#include <utility>

#include "command.h"
#include "given_trajectory.h"
#include "json_file.h"
#include "new_strips.h"
#include "option_checks.h"
#include "shown_text.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMaxAngleDeg = 180.0;
constexpr const char* kAdjustedTrajectory = "trajectory.out";
// The standard deviation across a Gaussian beam is a quarter of its divergence. The divergence is
// the full angle at which the intensity has fallen by the factor e^2.
constexpr double kBeamSigmas = 4.0;

struct GeorefOptions {
  CommonOptions common;
  std::string flight;
  std::string boresight;  ///< empty: from `result`, else from flight.yaml
  std::string trajectory;
  std::string result;
  bool anyway = false;  ///< also with a result that cannot be relied on
  bool covariance = false;
  double sigma_range_m = 0.02;
  double divergence_mrad = 0.35;
};

/// Boresight in a result.json.
struct StoredBoresight {
  std::string method;   ///< empty: the file has none
  std::string verdict;  ///< empty: the file has none
  Vector3d angles_rad = Vector3d::Zero();
  Matrix3d covariance_rad2 = Matrix3d::Zero();
  std::map<std::string, BeamErrors> beams = {};  ///< by the name of their scanner
};

[[noreturn]] void FailAngles(const std::string& text) {
  throw InvalidConfig("--boresight " + Quoted(text) +
                      " must be roll,pitch,yaw: three numbers in degrees within -180 and 180");
}

Vector3d ParseAngles(const std::string& text) {
  Vector3d angles_deg;
  std::size_t begin = 0;
  try {
    for (int i = 0; i < 3; ++i) {
      const std::size_t end = i < 2 ? text.find(',', begin) : text.size();
      if (end == std::string::npos) FailAngles(text);
      angles_deg[i] = ParseNumber(std::string_view(text).substr(begin, end - begin), {});
      begin = end + 1;
    }
  } catch (const InvalidInput&) {
    FailAngles(text);
  }
  if (angles_deg.cwiseAbs().maxCoeff() > kMaxAngleDeg) FailAngles(text);
  return angles_deg * kRadPerDeg;
}

StoredBoresight ReadBoresight(const JsonPlace& boresight) {
  StoredBoresight result;
  result.angles_rad = ReadFiniteVector3(boresight.At("angles_deg")) * kRadPerDeg;
  result.covariance_rad2 = ReadMatrix3(boresight.At("covariance_deg2")) * (kRadPerDeg * kRadPerDeg);
  const bool finite = result.covariance_rad2.allFinite();
  if (!finite || result.covariance_rad2.llt().info() != Eigen::Success) {
    boresight.At("covariance_deg2").Fail("is not positive definite");
  }
  return result;
}

/// Returns the values of a list, with 0 for each null: a beam that is not observable.
std::vector<double> ReadCorrections(const JsonPlace& list, double to_si) {
  std::vector<double> values;
  for (const JsonPlace& one : list.Elements(kMostBeams)) {
    values.push_back(one.is_null() ? 0.0 : to_si * one.Number());
  }
  return values;
}

BeamErrors ReadBeamErrors(const JsonPlace& beams) {
  BeamErrors errors;
  if (beams.Has("angle")) {
    errors.angle_rad = ReadCorrections(beams.At("angle").At("value"), kRadPerDeg);
  }
  if (beams.Has("range_offset")) {
    errors.range_m = ReadCorrections(beams.At("range_offset").At("value"), 1.0);
  }
  return errors;
}

/// Returns the errors of the beams of a scanner; nullopt if the result has none.
std::optional<BeamErrors> FindBeams(const StoredBoresight& result, const LidarConfig& lidar) {
  const auto found = result.beams.find(lidar.name);
  if (found == result.beams.end()) return std::nullopt;
  BeamErrors errors = found->second;
  errors.scan_axis_s = lidar.scan_axis_s;
  return errors;
}

/// Returns the part of a result that belongs to a scanner: an element of `scanners`, or all of it.
/// Returns nullopt and fills `others` if the result is of other scanners.
std::optional<JsonPlace> FindScannerResult(const JsonPlace& root, const std::string& scanner,
                                           std::vector<std::string>* others) {
  if (root.Has("scanners")) {
    for (const JsonPlace& one : root.At("scanners").Elements(kMostScanners)) {
      others->push_back(one.At("name").Text());
      if (others->back() == scanner) return one;
    }
    return std::nullopt;
  }
  if (!root.Has("scanner") || root.At("scanner").Text() == scanner) return root;
  others->push_back(root.At("scanner").Text());
  return std::nullopt;
}

StoredBoresight ReadScannerResult(const JsonPlace& root, const JsonPlace& own) {
  StoredBoresight result = ReadBoresight(own.At("boresight"));
  if (root.Has("beams")) {
    for (const JsonPlace& one : root.At("beams").Elements(kMostScanners)) {
      result.beams.emplace(one.At("scanner").Text(), ReadBeamErrors(one));
    }
  }
  if (root.Has("method")) result.method = root.At("method").Text();
  if (own.Has("assessment")) result.verdict = own.At("assessment").At("verdict").Text();
  return result;
}

/// Reads the result of the scanner with this name; empty for a flight without a list of scanners.
StoredBoresight ReadResult(const fs::path& file, const std::string& scanner) {
  std::vector<std::string> others;
  try {
    const Json json = ReadJsonFile(file);
    const JsonPlace root(json, file.string());
    const std::optional<JsonPlace> own = FindScannerResult(root, scanner, &others);
    if (own) return ReadScannerResult(root, *own);
  } catch (const InvalidInput& error) {
    throw InvalidInput(std::string("this is not a result of `dn calibrate`: ") + error.what(),
                       error.where());
  }
  throw InvalidInput(
      fmt::format(
          "this result is of scanner {}, but the strips are {}; give the result of their scanner",
          JoinNames(others),
          scanner.empty() ? "of a flight without a list of scanners" : "of " + scanner),
      {file.string()});
}

/// Throws InvalidInput if the verdict says that the angles of the result cannot be relied on. With
/// --anyway, and for absorbed angles, only warns.
void CheckVerdict(const GeorefOptions& given, const StoredBoresight& result, Run& run) {
  if (result.verdict == Word(Verdict::kAbsorbed)) {
    run.progress().Warn(
        "the result is absorbed: its angles make the points consistent with the data that it was "
        "computed from, but are not the mounting's; do not use them for another flight");
  }
  const bool contradicted = result.verdict == Word(Verdict::kContradicted);
  if (!contradicted && result.verdict != Word(Verdict::kNotObservable)) return;
  const std::string what =
      contradicted ? "the result is contradicted by its own data: its angles must not be relied on"
                   : "the result is not_observable: its data do not determine all of its angles";
  const FileLocation where{given.result};
  if (!given.anyway) {
    throw InvalidInput(what + "; correct the calibration, or add --anyway", where);
  }
  run.progress().Warn(fmt::format("{} ({}); used because of --anyway", what, given.result));
}

void ExpectTrajectory(const GeorefOptions& options, bool own) {
  if (own || !options.trajectory.empty()) return;
  throw InvalidInput(fmt::format(
      "the flight has no trajectory; make one with `dn smooth {} --out DIR` and give it with "
      "--trajectory DIR/trajectory.out",
      QuoteForShell(options.flight)));
}

StripErrors ReadErrors(const GeorefOptions& options, const FlightConfig& config,
                       const StoredBoresight* result) {
  const TrajectoryConfig& trajectory = *config.trajectory;
  StripErrors errors;
  const AccuracyFiles files = FindAccuracyFiles(config);
  if (files.series) errors.series.emplace(*files.series);
  errors.sigma_ned_m = Vector3d(trajectory.sigma_xy_m, trajectory.sigma_xy_m, trajectory.sigma_z_m);
  errors.sigma_rph_rad =
      Vector3d(trajectory.sigma_rp_rad, trajectory.sigma_rp_rad, trajectory.sigma_y_rad);
  if (result != nullptr) errors.boresight_rad2 = result->covariance_rad2;
  errors.sigma_range_m = options.sigma_range_m;
  errors.sigma_beam_rad = 1e-3 * options.divergence_mrad / kBeamSigmas;
  return errors;
}

Json CovarianceJson(const GeorefOptions& given, const FlightConfig& config) {
  if (!given.covariance) return nullptr;
  const AccuracyFiles files = FindAccuracyFiles(config);
  return {{"trajectory", files.series ? files.series->string() : "flight.yaml"},
          {"boresight", given.result.empty() ? Json() : Json(given.result)},
          {"sigma_range_m", given.sigma_range_m},
          {"divergence_mrad", given.divergence_mrad}};
}

/// Returns the trajectory that a network adjusted together with the boresight of --result; empty if
/// there is none. Clouds are most consistent on this one.
std::string AdjustedTrajectory(const std::string& file, const StoredBoresight& result) {
  if (result.method != "dn") return {};
  const fs::path beside = fs::path(file).parent_path() / kAdjustedTrajectory;
  return fs::exists(beside) ? beside.string() : std::string();
}

/// Returns the result of each scanner; none without --result. Throws InvalidInput if the verdict of
/// one forbids its use.
std::vector<StoredBoresight> ReadResults(const GeorefOptions& given,
                                         const std::vector<FlightConfig>& scanners, Run& run) {
  std::vector<StoredBoresight> results;
  if (given.result.empty()) return results;
  for (const FlightConfig& scanner : scanners) {
    results.push_back(ReadResult(given.result, scanner.lidar->name));
    CheckVerdict(given, results.back(), run);
  }
  return results;
}

/// Reads the trajectories of the new points and of the old ones. Sets the frame, and the
/// trajectory of the configuration.
GeoreferenceOptions ReadTrajectories(const GeorefOptions& given, FlightConfig* config,
                                     LocalFrame* frame) {
  const bool own = HasTrajectory(*config);
  ExpectTrajectory(given, own);
  Flight flight =
      ReadFlight(own ? *config : WithTrajectory(*config, given.trajectory), {.trajectory = true});
  *frame = flight.frame;
  GeoreferenceOptions options;
  options.trajectory = std::move(*flight.trajectory);
  if (own && !given.trajectory.empty()) {
    options.made_by =
        std::exchange(options.trajectory, ReadTrajectory(given.trajectory, TextColumns(*config)));
  }
  *config = WithTrajectory(std::move(flight.config), given.trajectory);
  return options;
}

NewStrips Prepare(GeorefOptions given, Run& run) {
  NewStrips work;
  work.config = ReadFlightConfig(given.flight, given.common.changes);
  std::optional<Vector3d> boresight_rad;
  if (!given.boresight.empty()) {
    ExpectOneScanner(work.config, "--boresight");
    boresight_rad = ParseAngles(given.boresight);
  }
  const std::vector<StoredBoresight> results =
      ReadResults(given, GeoreferenceableScanners(work.config), run);
  if (!results.empty() && given.trajectory.empty()) {
    given.trajectory = AdjustedTrajectory(given.result, results.front());
  }
  run.progress().Stage("reading " + work.config.folder.string());
  GeoreferenceOptions trajectories = ReadTrajectories(given, &work.config, &work.frame);
  trajectories.threads = run.options().threads;
  work.covariance = CovarianceJson(given, work.config);
  work.scanners = StatedStrips(work.config, std::move(trajectories));
  for (std::size_t k = 0; k < work.scanners.size(); ++k) {
    auto& [scanner, options] = work.scanners[k];
    const StoredBoresight* result = results.empty() ? nullptr : &results[k];
    if (result != nullptr) options.mounting.boresight_rad = result->angles_rad;
    if (boresight_rad) options.mounting.boresight_rad = *boresight_rad;
    if (result != nullptr) options.beams = FindBeams(*result, *scanner.lidar);
    if (given.covariance) options.errors = ReadErrors(given, scanner, result);
  }
  return work;
}

void RunGeoref(const GeorefOptions& given, Run& run) {
  NewStrips work = Prepare(given, run);
  run.report()["counts"] = Json::object();
  run.report()["flight"] = work.config.name;
  run.AddFile("config.resolved.yaml", FormatFlightConfig(work.config));
  GeoreferenceStrips(std::move(work), run);
}

void AddGeorefOptions(CLI::App* app, GeorefOptions* options) {
  AddFlightOptions(app, &options->flight, &options->common);
  app->add_option(
      "--boresight", options->boresight,
      "Boresight of the new points, roll,pitch,yaw [deg], as `dn calibrate` reports it. "
      "Default: from --result, else from flight.yaml");
  app->add_option(
      "--trajectory", options->trajectory,
      "Trajectory of the new points (SBET .out or text). Default: trajectory.out beside "
      "--result if the dynamic network made it, else that of the flight");
  app->add_option("--result", options->result,
                  "result.json of `dn calibrate` with the boresight and its covariance");
  app->add_flag("--anyway", options->anyway,
                "Uses --result even if it is contradicted or not_observable");
  app->add_flag("--covariance", options->covariance,
                "Also writes the covariance of every point, from trajectory, boresight and beam");
  app->add_option("--sigma-range-m", options->sigma_range_m,
                  "Standard deviation of a range [m], for --covariance")
      ->check(PositiveNumber())
      ->capture_default_str();
  app->add_option("--divergence-mrad", options->divergence_mrad,
                  "Beam divergence [mrad], for --covariance; a quarter of it is the standard "
                  "deviation of the beam direction")
      ->check(PositiveNumber())
      ->capture_default_str();
}

Inputs GeorefInputs(const GeorefOptions& options) {
  Inputs inputs = FlightInputs(options.flight, options.common.changes, options.trajectory);
  if (!options.result.empty()) {
    inputs.files.emplace_back(options.result);
    inputs.files.push_back(fs::path(options.result).parent_path() / kAdjustedTrajectory);
  }
  return inputs;
}

}  // namespace

void AddGeoref(CLI::App* program, Action* action) {
  auto options = std::make_shared<GeorefOptions>();
  CLI::App* app = program->add_subcommand(
      "georef", "Recomputes the point clouds of a flight with another boresight or trajectory");
  AddGeorefOptions(app, options.get());
  AddCommonOptions(app, &options->common, true);
  app->footer("Example: dn georef flight --boresight 0.1,-0.02,0.3 --out result");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = GeorefInputs(*options);
      return Execute("georef", options->common, [&](Run& run) { RunGeoref(*options, run); });
    };
  });
}

}  // namespace dn::apps
