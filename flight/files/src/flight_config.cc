#include <dn/error.h>
#include <dn/files/across.h>
#include <dn/files/flight_config.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/read_file.h>
#include <dn/names.h>

#include <algorithm>

#include "config_sections.h"
#include "is_there.h"
#include "scanner_list.h"

namespace dn {
namespace {

// Characters of `unexplained`: a part of the data with names of strips, and a shape.
constexpr std::size_t kLongestUnexplained = 1000;
constexpr std::size_t kMostStrips = 1000;

namespace fs = std::filesystem;

/// Returns flight.yaml of a flight folder, or the given file.
fs::path ConfigFile(const fs::path& folder_or_file) {
  if (fs::is_directory(folder_or_file)) {
    fs::path file = folder_or_file / "flight.yaml";
    if (files_internal::IsThere(file)) return file;
    throw InvalidConfig("the flight folder has no flight.yaml; write one with dn init",
                        FileLocation{file.string(), 0, 0});
  }
  if (files_internal::IsThere(folder_or_file)) return folder_or_file;
  throw InvalidConfig("there is no flight folder '" + folder_or_file.string() + "'");
}

std::string ReadText(const fs::path& file) {
  try {
    return ReadWholeFile(file, kMaxYamlBytes);
  } catch (const InvalidInput& e) {
    throw InvalidConfig(e.what(), e.where());
  }
}

Geodetic ReadOrigin(const YamlValue& value) {
  const Eigen::Vector3d v = ReadVector3(value);
  if (std::abs(v.x()) > 90.0) value.Fail("latitude must lie in -90..90 deg");
  if (std::abs(v.y()) > 360.0) value.Fail("longitude must lie in -360..360 deg");
  if (std::abs(v.z()) > 1e6) value.Fail("height must lie in -1e6..1e6 m");
  return {RadFromDeg(v.x()), RadFromDeg(v.y()), v.z()};
}

std::optional<Geodetic> ReadFrame(const YamlValue& section) {
  if (!section) return std::nullopt;
  section.ExpectMap({"origin_deg_m"});
  if (!section["origin_deg_m"]) return std::nullopt;
  return ReadOrigin(section["origin_deg_m"]);
}

std::optional<Eigen::Vector2d> ReadSpan(const YamlValue& value) {
  if (!value) return std::nullopt;
  const Eigen::Vector2d span = ReadNumbers(value, 2);
  if (!(span[0] < span[1])) value.Fail("must begin before it ends");
  return span;
}

StripInterval ReadStrip(const YamlValue& item) {
  item.ExpectMap({"name", "t0", "t1"});
  StripInterval strip{ReadName(item["name"]), item["t0"].Number(), item["t1"].Number()};
  if (!(strip.t0_s < strip.t1_s)) item["t1"].Fail("must be later than t0");
  return strip;
}

std::string ReadCrs(const YamlValue& value) {
  std::string crs = ReadName(value);
  if (!IsPointCrsName(crs)) {
    value.Fail("'" + crs +
               "' is not one of map, utm:ZONEn, utm:ZONEs (as utm:32n), ecef, epsg:CODE (as "
               "epsg:2056), none");
  }
  return ShortCrsName(crs);
}

GhConfig ReadGh(const YamlValue& section) {
  section.ExpectMap({"rotation", "libor_compat"});
  GhConfig gh;
  if (section["rotation"])
    gh.exponential = section["rotation"].Choice(files_internal::GhRotationWords());
  if (section["libor_compat"]) gh.libor_compat = section["libor_compat"].Bool();
  return gh;
}

NetworkConfig ReadNetwork(const YamlValue& section) {
  section.ExpectMap({"inertial", "node_rate_hz"});
  NetworkConfig network;
  if (section["inertial"])
    network.inertial = section["inertial"].Choice(files_internal::InertialWords());
  const YamlValue rate = section["node_rate_hz"];
  if (rate && !(rate.IsScalar() && rate.Text() == "auto"))
    network.node_rate_hz = ReadPositive(rate);
  return network;
}

void ReadSensors(const YamlValue& root, FlightConfig& config) {
  if (const YamlValue section = root["imu"]) {
    config.imu = files_internal::ReadImuSection(section, config.body_is_flu);
    if (config.time_span_s) {
      config.imu->read.t_begin_s = config.time_span_s->x();
      config.imu->read.t_end_s = config.time_span_s->y();
    }
  }
  if (const YamlValue section = root["gnss"]) {
    config.gnss = files_internal::ReadGnssSection(section, config.body_is_flu);
  }
  if (const YamlValue section = root["trajectory"]) {
    config.trajectory = files_internal::ReadTrajectorySection(section);
  }
}

/// Returns whether the first data file of the configuration is in the folder.
bool HoldsData(const fs::path& folder, const FlightConfig& config) {
  if (config.imu) return files_internal::IsThere(folder / config.imu->file);
  if (config.gnss) return files_internal::IsThere(folder / config.gnss->file);
  return !config.trajectory || files_internal::IsThere(folder / config.trajectory->file);
}

/// Returns the folder of the data for a configuration file in `folder`.
fs::path DataFolder(const YamlValue& key, const fs::path& folder, const FlightConfig& config) {
  return key && !HoldsData(folder, config) ? folder / key.Text() : folder;
}

// Removes control characters, which the name of a folder may have.
std::string FolderName(const fs::path& folder) {
  const fs::path full = fs::weakly_canonical(folder);
  return WithoutControls(full.filename().string());
}

FlightConfig ParseFile(const std::string& text, const fs::path& file) {
  const YamlValue root = ParseYaml(text, file.string());
  root.ExpectMap({"name",       "data_folder", "body", "frame",      "time_span_s",   "strips",
                  "strips_crs", "imu",         "gnss", "lidar",      "pairs_between", "scanner",
                  "trajectory", "control",     "gh",   "unmodelled", "estimate",      "across",
                  "network",    "unexplained", "ties"});
  FlightConfig config;
  config.file = file;
  if (root["body"]) config.body_is_flu = root["body"].Choice(files_internal::BodyWords());
  config.origin = ReadFrame(root["frame"]);
  config.time_span_s = ReadSpan(root["time_span_s"]);
  config.strips = ReadStrips(root["strips"]);
  config.strips_crs_stated = static_cast<bool>(root["strips_crs"]);
  if (config.strips_crs_stated) config.strips_crs = ReadCrs(root["strips_crs"]);
  ReadSensors(root, config);
  const std::vector<std::string> scanners = files_internal::ReadScanners(root, &config);
  if (root["control"]) config.control = files_internal::ReadControlSection(root["control"]);
  if (root["ties"]) config.ties = files_internal::ReadTiesSection(root["ties"]);
  if (root["gh"]) config.gh = ReadGh(root["gh"]);
  if (root["unmodelled"]) {
    config.unmodelled = files_internal::ReadUnmodelled(root["unmodelled"]);
  }
  if (root["estimate"]) config.estimate = files_internal::ReadEstimate(root["estimate"]);
  AssignScanners(scanners, &config);
  ParseAcross(root["across"]);  // belongs to several flights; here it is only checked
  if (root["network"]) config.network = ReadNetwork(root["network"]);
  if (root["unexplained"]) config.unexplained = root["unexplained"].Line(kLongestUnexplained);
  config.folder = DataFolder(root["data_folder"], file.parent_path(), config);
  config.name = root["name"] ? ReadName(root["name"]) : FolderName(config.folder);
  return config;
}

}  // namespace

std::vector<StripInterval> ReadStrips(const YamlValue& list) {
  std::vector<StripInterval> strips;
  if (!list) return strips;
  for (const YamlValue& item : list.List(kMostStrips)) {
    StripInterval strip = ReadStrip(item);
    const auto same = [&](const StripInterval& s) { return s.name == strip.name; };
    if (std::any_of(strips.begin(), strips.end(), same)) {
      item["name"].Fail("strip '" + strip.name + "' is given twice");
    }
    strips.push_back(std::move(strip));
  }
  return strips;
}

FlightConfig ParseFlightConfig(const std::string& text, const fs::path& folder) {
  return ParseFile(text, folder / "flight.yaml");
}

TrajectoryColumns TextColumns(const FlightConfig& config) {
  TrajectoryColumns columns;
  if (config.trajectory) columns = config.trajectory->columns;
  columns.body_is_flu = config.body_is_flu;
  columns.map_origin = config.origin;
  return columns;
}

FlightConfig ReadFlightConfig(const fs::path& folder_or_file,
                              const std::vector<std::string>& changes) {
  const fs::path file = ConfigFile(folder_or_file);
  FlightConfig config =
      ParseFile(WithYamlChanges(ReadText(file), changes, "gnss.sigma_scale=2"), file);
  if (config.strips_crs_stated) return config;
  const std::string stated = FindStripsCrs(config);
  if (!stated.empty()) config.strips_crs = stated;
  return config;
}

AcrossConfig ReadAcross(const std::filesystem::path& folder_or_file) {
  const fs::path file = ConfigFile(folder_or_file);
  return ParseAcross(ParseYaml(ReadText(file), file.string())["across"]);
}

}  // namespace dn
