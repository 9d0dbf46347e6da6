#include "new_strips.h"

#include <dn/adjustment/words.h>
#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/interrupted.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
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
      {"disagreement", strip.disagreement.empty() ? Json() : Json(strip.disagreement)},
      {"crs", CrsJson(crs)}};
}

void AddCounts(const Json& strip, Json* counts) {
  const auto add = [&](const std::string& what, const Json& count) {
    (*counts)[what] = counts->value(what, std::uint64_t{0}) + count.get<std::uint64_t>();
  };
  add("points", strip["points"]);
  add("points kept", strip["kept"]);
  for (const auto& [reason, count] : strip["dropped"].items()) add("points " + reason, count);
}

/// Returns a name that tells apart the strips of several scanners: nadir_1.
std::string NameAmongScanners(const std::string& scanner, const std::string& strip) {
  return scanner.empty() ? strip : scanner + "_" + strip;
}

/// Georeferences the strips of all scanners, and collects what is to be said of them.
class Georeferencing {
 public:
  Georeferencing(const LocalFrame& frame, const PointCrs& crs, Run* run)
      : frame_(frame), crs_(crs), run_(*run) {}

  void AddScanner(ScannerStrips scanner) {
    const StripGeoreferencer georeferencer(std::move(scanner.options), frame_, crs_);
    for (const fs::path& file : FindStripFiles(scanner.config)) {
      AddStrip(georeferencer, file, scanner.config);
    }
  }

  const Json& strips() const { return strips_; }
  const std::vector<Swath>& swaths() const { return swaths_; }
  const std::vector<StripSurfaces>& surfaces() const { return surfaces_; }

 private:
  /// Georeferences one strip and stages the new file.
  void AddStrip(const StripGeoreferencer& georeferencer, const fs::path& file,
                const FlightConfig& config) {
    const std::string& scanner = config.lidar->name;
    const std::string name = file.filename().string();
    const std::string shown = file.parent_path().filename().string() + "/" + name;
    const std::string stage = "strip " + (scanner.empty() ? name : shown);
    run_.progress().Stage(stage);
    const auto reader = OpenStrip(file);
    const StripCrs said = reader->crs();
    const std::string warning = CheckStripCrs(said, config.strips_crs, file);
    if (!warning.empty()) run_.progress().Warn(warning);
    GeoreferencedStrip strip =
        georeferencer.Run(file, run_.files().Stage(shown), ShowPoints(stage, reader->points()));
    const std::string assumed = VectorWarning(strip.origin, name);
    if (!assumed.empty()) run_.progress().Warn(assumed);
    if (!strip.disagreement.empty()) run_.progress().Warn(name + ": " + strip.disagreement);
    strip.swath.strip = NameAmongScanners(scanner, file.stem().string());
    surfaces_.push_back(
        {strip.swath.strip, std::move(strip.surface_before), std::move(strip.surface_after)});
    swaths_.push_back(std::move(strip.swath));
    Json entry = StripJson(name, said, strip);
    if (!scanner.empty()) entry["scanner"] = scanner;
    AddCounts(entry, &run_.report()["counts"]);
    strips_.push_back(std::move(entry));
  }

  std::function<void(std::uint64_t)> ShowPoints(const std::string& stage,
                                                std::optional<std::uint64_t> all) {
    return [this, stage, all](std::uint64_t points) {
      if (SignalReceived()) throw dn::Interrupted();
      if (all) {
        run_.progress().Stage(
            stage, Share{static_cast<double>(points), static_cast<double>(*all), "points"});
      } else {
        run_.progress().Stage(stage, fmt::format("{} points", points));
      }
    };
  }

  const LocalFrame& frame_;
  const PointCrs& crs_;
  Run& run_;
  Json strips_ = Json::array();
  std::vector<Swath> swaths_;
  std::vector<StripSurfaces> surfaces_;
};

/// Sets the side of the cells in which strips are compared. Four ground sampling distances of the
/// coarsest scanner give some sixteen points per cell. One strip has nothing to compare.
void SetSurfaceCells(std::vector<ScannerStrips>* scanners) {
  constexpr double kSmallestCell_m = 2.0, kCell_gsd = 4.0;
  std::size_t files = 0;
  double cell_m = kSmallestCell_m;
  for (const ScannerStrips& scanner : *scanners) {
    files += FindStripFiles(scanner.config).size();
    cell_m = std::max(cell_m, kCell_gsd * scanner.config.lidar->gsd_m.value_or(0.0));
  }
  if (files < 2) return;
  for (ScannerStrips& scanner : *scanners) scanner.options.surface_cell_m = cell_m;
}

Json AnglesJson(const ScannerStrips& scanner) {
  return {{"boresight_deg", AnglesInDegrees(scanner.options.mounting.boresight_rad)},
          {"boresight_before_deg", AnglesInDegrees(scanner.config.lidar->mounting.boresight_rad)}};
}

/// Returns georef.json without the strips. The boresight is that of the first scanner; a list of
/// scanners also has all of them in `scanners`.
Json GeorefJson(const NewStrips& work) {
  const FlightConfig& config = work.config;
  Json georef = {{"schema", "dn.georef/1"},
                 {"flight", config.name},
                 {"strips_crs", config.strips_crs},
                 {"trajectory", config.trajectory->file},
                 {"covariance", work.covariance}};
  georef.update(AnglesJson(work.scanners.front()));
  if (work.scanners.size() == 1) return georef;
  for (const ScannerStrips& scanner : work.scanners) {
    Json one = AnglesJson(scanner);
    one["name"] = scanner.config.lidar->name;
    georef["scanners"].push_back(std::move(one));
  }
  return georef;
}

void PrintBoresight(const Json& georef, const Json& scanner) {
  const Json& deg = scanner["boresight_deg"];
  const std::string name = scanner.value("name", "");
  fmt::print("flight {}{}, boresight {:.6f} {:.6f} {:.6f} deg, points in {}\n",
             georef["flight"].get<std::string>(), name.empty() ? "" : ", scanner " + name,
             deg[0].get<double>(), deg[1].get<double>(), deg[2].get<double>(),
             ShownCrsName(georef["strips_crs"].get<std::string>()));
}

void Print(const Json& georef) {
  if (!georef.contains("scanners")) PrintBoresight(georef, georef);
  for (const Json& scanner : georef.value("scanners", Json::array())) {
    PrintBoresight(georef, scanner);
  }
  fmt::print("  {:<24} {:>12} {:>12} {:>10} {:>10}  {}\n", "strip", "kept", "dropped", "moved rms",
             "max [m]", "laser vectors");
  for (const Json& strip : georef["strips"]) {
    const auto points = strip["points"].get<std::uint64_t>();
    const auto kept = strip["kept"].get<std::uint64_t>();
    const std::string name =
        NameAmongScanners(strip.value("scanner", ""), strip["name"].get<std::string>());
    fmt::print("  {:<24} {:>12} {:>12} {:>10.4f} {:>10.4f}  {}\n", name, kept, points - kept,
               strip["shift_rms_m"].get<double>(), strip["shift_max_m"].get<double>(),
               strip["laser_vectors"].get<std::string>());
  }
}

}  // namespace

std::vector<FlightConfig> GeoreferenceableScanners(const FlightConfig& config) {
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
  RequireStripFiles(config);
  std::vector<FlightConfig> scanners;
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    if (FindStripFiles(config, k).empty()) continue;
    scanners.push_back(config);
    KeepScanner(k, &scanners.back());
  }
  return scanners;
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

std::vector<ScannerStrips> StatedStrips(const FlightConfig& config,
                                        GeoreferenceOptions trajectories) {
  std::vector<ScannerStrips> scanners;
  for (FlightConfig& scanner : GeoreferenceableScanners(config)) {
    scanners.push_back({std::move(scanner), {}});
  }
  // A trajectory is large: one scanner needs no copy.
  for (std::size_t k = 1; k < scanners.size(); ++k) scanners[k].options = trajectories;
  scanners.front().options = std::move(trajectories);
  for (auto& [scanner, options] : scanners) {
    options.made_with = StripsGeoreferencing(scanner);
    options.mounting = scanner.lidar->mounting;
    options.time_span_s = scanner.time_span_s;
    options.time_offset_s = scanner.lidar->time_offset_s;
  }
  return scanners;
}

void GeoreferenceStrips(NewStrips work, Run& run) {
  run.ReadsStrips();
  SetSurfaceCells(&work.scanners);
  const PointCrs crs(work.config.strips_crs, work.frame);
  Json georef = GeorefJson(work);
  Georeferencing georeferencing(work.frame, crs, &run);
  for (ScannerStrips& scanner : work.scanners) georeferencing.AddScanner(std::move(scanner));
  georef["strips"] = georeferencing.strips();
  Print(georef);
  const Json differences = CompareStrips(georeferencing.surfaces(), crs, &run);
  if (!differences.empty()) georef["strip_differences"] = differences;
  run.AddFile("georef.json", FormatJson(georef));
  if (!HasSwathFiles(run)) AddSwathFiles(georeferencing.swaths(), work.frame, &run);
}

}  // namespace dn::apps
