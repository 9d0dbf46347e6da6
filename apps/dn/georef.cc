#include <dn/adjustment/swaths.h>
#include <dn/adjustment/words.h>
#include <dn/error.h>
#include <dn/files/accuracy_files.h>
#include <dn/files/flight.h>
#include <dn/files/georeference_strip.h>
#include <dn/files/strip_files.h>
#include <dn/geo/text_table.h>
#include <dn/interrupted.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <utility>

#include "command.h"
#include "given_trajectory.h"
#include "json_file.h"
#include "option_checks.h"
#include "shown_text.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMaxAngleDeg = 180.0;
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
  std::string verdict;  ///< empty: the file has none
  Vector3d angles_rad = Vector3d::Zero();
  Matrix3d covariance_rad2 = Matrix3d::Zero();
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

StoredBoresight ReadResult(const fs::path& file) {
  try {
    const Json json = ReadJsonFile(file);
    const JsonPlace root(json, file.string());
    StoredBoresight result = ReadBoresight(root.At("boresight"));
    if (root.Has("assessment")) result.verdict = root.At("assessment").At("verdict").Text();
    return result;
  } catch (const InvalidInput& error) {
    throw InvalidInput(std::string("this is not a result of `dn calibrate`: ") + error.what(),
                       error.where());
  }
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

void ExpectGeoreferenceable(const FlightConfig& config) {
  const FileLocation where{config.file.string()};
  if (!config.lidar) {
    throw InvalidConfig("the section 'lidar' is missing, and this command needs it", where);
  }
  if (config.strips_crs == "none") {
    throw InvalidConfig(
        "strips_crs is 'none': points in an unknown system cannot be georeferenced; write map, "
        "utm:ZONEn, utm:ZONEs or ecef",
        where);
  }
}

void ExpectTrajectory(const GeorefOptions& options, bool own) {
  if (own || !options.trajectory.empty()) return;
  throw InvalidInput(fmt::format(
      "the flight has no trajectory; make one with `dn smooth {} --out DIR` and give it with "
      "--trajectory DIR/trajectory.out",
      QuoteForShell(options.flight)));
}

StripErrors ReadErrors(const GeorefOptions& options, const FlightConfig& config,
                       const std::optional<StoredBoresight>& result) {
  const TrajectoryConfig& trajectory = *config.trajectory;
  StripErrors errors;
  const AccuracyFiles files = FindAccuracyFiles(config);
  if (files.series) errors.series.emplace(*files.series);
  errors.sigma_ned_m = Vector3d(trajectory.sigma_xy_m, trajectory.sigma_xy_m, trajectory.sigma_z_m);
  errors.sigma_rph_rad =
      Vector3d(trajectory.sigma_rp_rad, trajectory.sigma_rp_rad, trajectory.sigma_y_rad);
  if (result) errors.boresight_rad2 = result->covariance_rad2;
  errors.sigma_range_m = options.sigma_range_m;
  errors.sigma_beam_rad = 1e-3 * options.divergence_mrad / kBeamSigmas;
  return errors;
}

/// Everything that the command reads except the points.
struct Georef {
  FlightConfig config;  ///< names the trajectory of the new points
  LocalFrame frame{Geodetic{}};
  GeoreferenceOptions options;
  std::string accuracy;  ///< source of the trajectory's sigmas
};

Georef Prepare(const GeorefOptions& given, Run& run) {
  const FlightConfig config = ReadFlightConfig(given.flight);
  ExpectGeoreferenceable(config);
  std::optional<Vector3d> boresight_rad;
  if (!given.boresight.empty()) boresight_rad = ParseAngles(given.boresight);
  std::optional<StoredBoresight> result;
  if (!given.result.empty()) result = ReadResult(given.result);
  if (result) CheckVerdict(given, *result, run);
  if (result && !boresight_rad) boresight_rad = result->angles_rad;
  const bool own = HasTrajectory(config);
  ExpectTrajectory(given, own);
  run.progress().Stage("reading " + config.folder.string());
  Flight flight =
      ReadFlight(own ? config : WithTrajectory(config, given.trajectory), {.trajectory = true});

  Georef georef;
  georef.config = WithTrajectory(flight.config, given.trajectory);
  georef.frame = flight.frame;
  GeoreferenceOptions& options = georef.options;
  options.trajectory = std::move(*flight.trajectory);
  if (own && !given.trajectory.empty()) {
    options.made_by =
        std::exchange(options.trajectory, ReadTrajectory(given.trajectory, TextColumns(config)));
  }
  options.made_with = StripsGeoreferencing(config);
  options.mounting = config.lidar->mounting;
  if (boresight_rad) options.mounting.boresight_rad = *boresight_rad;
  options.time_span_s = config.time_span_s;
  options.time_offset_s = config.lidar->time_offset_s;
  options.threads = run.options().threads;
  if (given.covariance) options.errors = ReadErrors(given, georef.config, result);
  return georef;
}

Json AnglesInDegrees(const Vector3d& rad) {
  const Vector3d deg = rad * kDegPerRad;
  return {deg.x(), deg.y(), deg.z()};
}

Json CrsJson(const StripCrs& crs) {
  return {{"epsg", crs.epsg ? Json(*crs.epsg) : Json()},
          {"text", crs.text},
          {"heights_from_geoid", crs.heights_from_geoid}};
}

Json StripJson(const std::string& name, const StripCrs& crs, const GeoreferencedStrip& strip) {
  return {
      {"name", name},
      {"points", strip.points},
      {"kept", strip.kept},
      {"dropped", strip.dropped},
      {"laser_vectors", strip.origin.kind == VectorOrigin::Kind::kMeasured ? "file" : "trajectory"},
      {"laser_vectors_origin", Word(strip.origin.kind)},
      {"t_begin_s", strip.t_begin_s},
      {"t_end_s", strip.t_end_s},
      {"shift_rms_m", strip.shift_rms_m},
      {"shift_max_m", strip.shift_max_m},
      {"crs", CrsJson(crs)}};
}

Json CovarianceJson(const GeorefOptions& given, const FlightConfig& config) {
  if (!given.covariance) return nullptr;
  const AccuracyFiles files = FindAccuracyFiles(config);
  return {{"trajectory", files.series ? files.series->string() : "flight.yaml"},
          {"boresight", given.result.empty() ? Json() : Json(given.result)},
          {"sigma_range_m", given.sigma_range_m},
          {"divergence_mrad", given.divergence_mrad}};
}

/// Georeferences one strip, stages the new file and returns the strip's report entry.
Json RegeoreferenceStrip(const StripGeoreferencer& georeferencer, const fs::path& file,
                         const std::string& strips_crs, std::vector<Swath>* swaths, Run& run) {
  const std::string name = file.filename().string();
  const std::string stage = "strip " + name;
  run.progress().Stage(stage);
  const auto reader = OpenStrip(file);
  const StripCrs crs = reader->crs();
  const std::optional<std::uint64_t> all = reader->points();
  const std::string warning = CheckStripCrs(crs, strips_crs, file);
  if (!warning.empty()) run.progress().Warn(warning);
  GeoreferencedStrip strip =
      georeferencer.Run(file, run.files().Stage("strips/" + name), [&](std::uint64_t points) {
        if (SignalReceived()) throw dn::Interrupted();
        if (all) {
          run.progress().Stage(
              stage, Share{static_cast<double>(points), static_cast<double>(*all), "points"});
        } else {
          run.progress().Stage(stage, fmt::format("{} points", points));
        }
      });
  const std::string assumed = VectorWarning(strip.origin, name);
  if (!assumed.empty()) run.progress().Warn(assumed);
  strip.swath.strip = file.stem().string();
  swaths->push_back(std::move(strip.swath));
  return StripJson(name, crs, strip);
}

void AddCounts(const Json& strip, Json* counts) {
  const auto add = [&](const std::string& what, const Json& count) {
    (*counts)[what] = counts->value(what, std::uint64_t{0}) + count.get<std::uint64_t>();
  };
  add("points", strip["points"]);
  add("points kept", strip["kept"]);
  for (const auto& [reason, count] : strip["dropped"].items()) add("points " + reason, count);
}

void Print(const FlightConfig& config, const Vector3d& boresight_rad, const Json& strips) {
  const Vector3d boresight_deg = boresight_rad * kDegPerRad;
  fmt::print("flight {}, boresight {:.6f} {:.6f} {:.6f} deg, points in {}\n", config.name,
             boresight_deg.x(), boresight_deg.y(), boresight_deg.z(), config.strips_crs);
  fmt::print("  {:<24} {:>12} {:>12} {:>10} {:>10}  {}\n", "strip", "kept", "dropped", "moved rms",
             "max [m]", "laser vectors");
  for (const Json& strip : strips) {
    const auto points = strip["points"].get<std::uint64_t>();
    const auto kept = strip["kept"].get<std::uint64_t>();
    fmt::print("  {:<24} {:>12} {:>12} {:>10.4f} {:>10.4f}  {}\n", strip["name"].get<std::string>(),
               kept, points - kept, strip["shift_rms_m"].get<double>(),
               strip["shift_max_m"].get<double>(), strip["laser_vectors"].get<std::string>());
  }
}

void RunGeoref(const GeorefOptions& given, Run& run) {
  Georef georef = Prepare(given, run);
  run.ReadsStrips();
  const FlightConfig& config = georef.config;
  const std::vector<fs::path> files = RequireStripFiles(config.folder);
  const Vector3d boresight_rad = georef.options.mounting.boresight_rad;
  const StripGeoreferencer georeferencer(std::move(georef.options), georef.frame,
                                         PointCrs(config.strips_crs, georef.frame));
  Json strips = Json::array();
  std::vector<Swath> swaths;
  Json& counts = run.report()["counts"] = Json::object();
  for (const fs::path& file : files) {
    strips.push_back(RegeoreferenceStrip(georeferencer, file, config.strips_crs, &swaths, run));
    AddCounts(strips.back(), &counts);
  }
  run.report()["flight"] = config.name;
  run.AddFile(
      "georef.json",
      FormatJson({{"schema", "dn.georef/1"},
                  {"flight", config.name},
                  {"strips_crs", config.strips_crs},
                  {"trajectory", config.trajectory->file},
                  {"boresight_deg", AnglesInDegrees(boresight_rad)},
                  {"boresight_before_deg", AnglesInDegrees(config.lidar->mounting.boresight_rad)},
                  {"covariance", CovarianceJson(given, config)},
                  {"strips", strips}}));
  run.AddFile("swaths.json", FormatSwaths(swaths));
  run.AddFile("config.resolved.yaml", FormatFlightConfig(config));
  Print(config, boresight_rad, strips);
}

void AddGeorefOptions(CLI::App* app, GeorefOptions* options) {
  app->add_option("FLIGHT", options->flight, "Flight folder or YAML file of a flight")->required();
  app->add_option(
      "--boresight", options->boresight,
      "Boresight of the new points, roll,pitch,yaw [deg], as `dn calibrate` reports it. "
      "Default: from --result, else from flight.yaml");
  app->add_option("--trajectory", options->trajectory,
                  "Trajectory of the new points (SBET .out or text). Default: that of the flight");
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
  Inputs inputs = FlightInputs(options.flight, {}, options.trajectory);
  if (!options.result.empty()) inputs.files.emplace_back(options.result);
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
