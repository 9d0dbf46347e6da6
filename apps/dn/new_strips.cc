#include "new_strips.h"

#include <dn/adjustment/words.h>
#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/interrupted.h>
#include <fmt/format.h>

#include <utility>

#include "interruption.h"
#include "strip_differences.h"
#include "swath_files.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

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

/// Georeferences one strip, stages the new file and returns the strip's report entry.
Json RegeoreferenceStrip(const StripGeoreferencer& georeferencer, const fs::path& file,
                         const std::string& strips_crs, std::vector<Swath>* swaths,
                         std::vector<StripSurfaces>* surfaces, Run& run) {
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
  surfaces->push_back(
      {strip.swath.strip, std::move(strip.surface_before), std::move(strip.surface_after)});
  swaths->push_back(std::move(strip.swath));
  return StripJson(name, crs, strip);
}

// A cell of four ground sampling distances contains some sixteen points.
double SurfaceCell(const LidarConfig& lidar) {
  constexpr double kSmallestCellM = 2.0, kCellInGsd = 4.0;
  return std::max(kSmallestCellM, kCellInGsd * lidar.gsd_m.value_or(0.0));
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
             boresight_deg.x(), boresight_deg.y(), boresight_deg.z(),
             ShownCrsName(config.strips_crs));
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

}  // namespace

void ExpectGeoreferenceable(const FlightConfig& config) {
  const FileLocation where{config.file.string()};
  if (!config.lidar) {
    throw InvalidConfig("the section 'lidar' is missing, and this command needs it", where);
  }
  ExpectOneScanner(config, "georeferencing");
  if (config.strips_crs == "none") {
    throw InvalidConfig(
        "strips_crs is 'none': points in an unknown system cannot be georeferenced; write map, "
        "utm:ZONEn, utm:ZONEs or ecef",
        where);
  }
}

void ExpectBeamsInStrips(const FlightConfig& config) {
  if (!config.lidar->beams) return;
  for (const fs::path& file : RequireStripFiles(config)) {
    const auto reader = OpenStrip(file);
    StripCloud points;
    if (!reader->Next(&points) || (reader->has_vectors() && !points.beam.empty())) continue;
    throw InvalidInput(
        "the points have no laser vectors with beams, so that corrections of the beams cannot be "
        "applied; add the beams, or calibrate without --georef",
        {file.string()});
  }
}

GeoreferenceOptions StatedGeoreferencing(const FlightConfig& config, int threads) {
  GeoreferenceOptions options;
  options.made_with = StripsGeoreferencing(config);
  options.mounting = config.lidar->mounting;
  options.time_span_s = config.time_span_s;
  options.time_offset_s = config.lidar->time_offset_s;
  options.threads = threads;
  return options;
}

void GeoreferenceStrips(NewStrips work, Run& run) {
  run.ReadsStrips();
  const FlightConfig& config = work.config;
  const std::vector<fs::path> files = RequireStripFiles(config);
  const Vector3d boresight_rad = work.options.mounting.boresight_rad;
  if (files.size() > 1) work.options.surface_cell_m = SurfaceCell(*config.lidar);
  const PointCrs crs(config.strips_crs, work.frame);
  const StripGeoreferencer georeferencer(std::move(work.options), work.frame, crs);
  Json strips = Json::array();
  std::vector<Swath> swaths;
  std::vector<StripSurfaces> surfaces;
  Json& counts = run.report()["counts"];
  for (const fs::path& file : files) {
    strips.push_back(
        RegeoreferenceStrip(georeferencer, file, config.strips_crs, &swaths, &surfaces, run));
    AddCounts(strips.back(), &counts);
  }
  Print(config, boresight_rad, strips);
  Json georef = {{"schema", "dn.georef/1"},
                 {"flight", config.name},
                 {"strips_crs", config.strips_crs},
                 {"trajectory", config.trajectory->file},
                 {"boresight_deg", AnglesInDegrees(boresight_rad)},
                 {"boresight_before_deg", AnglesInDegrees(config.lidar->mounting.boresight_rad)},
                 {"covariance", work.covariance},
                 {"strips", strips}};
  const Json differences = CompareStrips(surfaces, crs, &run);
  if (!differences.empty()) georef["strip_differences"] = differences;
  run.AddFile("georef.json", FormatJson(georef));
  if (!HasSwathFiles(run)) AddSwathFiles(swaths, work.frame, &run);
}

}  // namespace dn::apps
