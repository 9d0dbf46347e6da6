#include <dn/error.h>
#include <dn/flight/flight_config.h>
#include <dn/geo/read_file.h>
#include <dn/names.h>

#include <algorithm>
#include <regex>

#include "config_sections.h"

namespace dn {
namespace {

namespace fs = std::filesystem;

std::string ReadText(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw InvalidConfig("there is no flight folder '" + folder.string() + "'");
  }
  const fs::path file = folder / "flight.yaml";
  std::error_code none;
  if (fs::status(file, none).type() == fs::file_type::not_found) {
    throw InvalidConfig("the flight folder has no flight.yaml; docs/flight.yaml is a model",
                        FileLocation{file.string(), 0, 0});
  }
  try {
    return ReadWholeFile(file, kMostYamlBytes);
  } catch (const InvalidInput& e) {
    throw InvalidConfig(e.what(), e.where());
  }
}

Geodetic ReadOrigin(const YamlValue& value) {
  const Eigen::Vector3d v = value.Vector3();
  if (std::abs(v.x()) > 90.0) value.Fail("latitude must lie in -90..90 deg");
  if (std::abs(v.y()) > 360.0) value.Fail("longitude must lie in -360..360 deg");
  if (std::abs(v.z()) > 1e6) value.Fail("height must lie in -1e6..1e6 m");
  return {internal::RadFromDeg(v.x()), internal::RadFromDeg(v.y()), v.z()};
}

std::optional<Geodetic> ReadFrame(const YamlValue& section) {
  if (!section) return std::nullopt;
  section.ExpectMap({"origin_deg_m"});
  if (!section["origin_deg_m"]) return std::nullopt;
  return ReadOrigin(section["origin_deg_m"]);
}

std::optional<Eigen::Vector2d> ReadSpan(const YamlValue& value) {
  if (!value) return std::nullopt;
  const Eigen::Vector2d span = value.Numbers(2);
  if (!(span[0] < span[1])) value.Fail("must begin before it ends");
  return span;
}

StripInterval ReadStrip(const YamlValue& item) {
  item.ExpectMap({"name", "t0", "t1"});
  StripInterval strip{item["name"].Name(), item["t0"].Number(), item["t1"].Number()};
  if (!(strip.t0_s < strip.t1_s)) item["t1"].Fail("must be later than t0");
  return strip;
}

std::vector<StripInterval> ReadStrips(const YamlValue& value) {
  std::vector<StripInterval> strips;
  if (!value) return strips;
  for (const YamlValue& item : value.List()) {
    StripInterval strip = ReadStrip(item);
    const auto same = [&](const StripInterval& s) { return s.name == strip.name; };
    if (std::any_of(strips.begin(), strips.end(), same)) {
      item["name"].Fail("strip '" + strip.name + "' is given twice");
    }
    strips.push_back(std::move(strip));
  }
  return strips;
}

std::string ReadCrs(const YamlValue& value) {
  static const std::regex utm("utm:([1-9]|[1-5][0-9]|60)[ns]");
  std::string crs = value.Name();
  if (crs != "map" && crs != "ecef" && crs != "none" && !std::regex_match(crs, utm)) {
    value.Fail("'" + crs + "' is none of map, utm:ZONEn, utm:ZONEs (as utm:32n), ecef, none");
  }
  return crs;
}

GhConfig ReadGh(const YamlValue& section) {
  section.ExpectMap({"rotation", "libor_compat"});
  GhConfig gh;
  if (section["rotation"]) gh.exponential = section["rotation"].Choice(internal::GhRotationWords());
  if (section["libor_compat"]) gh.libor_compat = section["libor_compat"].Bool();
  return gh;
}

NetworkConfig ReadNetwork(const YamlValue& section) {
  section.ExpectMap({"inertial", "node_rate_hz"});
  NetworkConfig network;
  if (section["inertial"]) network.inertial = section["inertial"].Choice(internal::InertialWords());
  const YamlValue rate = section["node_rate_hz"];
  if (rate && !(rate.IsScalar() && rate.Text() == "auto")) network.node_rate_hz = rate.Positive();
  return network;
}

void ReadSensors(const YamlValue& root, FlightConfig& config) {
  if (const YamlValue section = root["imu"]) {
    config.imu = internal::ReadImuSection(section);
    config.imu->read.body_is_flu = config.body_is_flu;
    if (config.time_span_s) {
      config.imu->read.t_begin_s = config.time_span_s->x();
      config.imu->read.t_end_s = config.time_span_s->y();
    }
  }
  if (const YamlValue section = root["gnss"]) {
    config.gnss = internal::ReadGnssSection(section, config.body_is_flu);
  }
  if (const YamlValue section = root["lidar"]) {
    config.lidar = internal::ReadLidarSection(section, config.body_is_flu);
  }
  if (const YamlValue section = root["trajectory"]) {
    config.trajectory = internal::ReadTrajectorySection(section);
  }
}

// A folder may be called anything.
std::string NameOfFolder(const fs::path& folder) {
  const fs::path full = fs::weakly_canonical(folder);
  return WithoutControls(full.filename().string());
}

}  // namespace

FlightConfig ParseFlightConfig(const std::string& text, const fs::path& folder) {
  const YamlValue root = ParseYaml(text, (folder / "flight.yaml").string());
  root.ExpectMap({"name", "body", "frame", "time_span_s", "strips", "strips_crs", "imu", "gnss",
                  "lidar", "trajectory", "gh", "estimate", "network"});
  FlightConfig config;
  config.folder = folder;
  config.name = root["name"] ? root["name"].Name() : NameOfFolder(folder);
  if (root["body"]) config.body_is_flu = root["body"].Choice(internal::BodyWords());
  config.origin = ReadFrame(root["frame"]);
  config.time_span_s = ReadSpan(root["time_span_s"]);
  config.strips = ReadStrips(root["strips"]);
  if (root["strips_crs"]) config.strips_crs = ReadCrs(root["strips_crs"]);
  ReadSensors(root, config);
  if (root["gh"]) config.gh = ReadGh(root["gh"]);
  if (root["estimate"]) config.estimate = internal::ReadEstimate(root["estimate"]);
  if (root["network"]) config.network = ReadNetwork(root["network"]);
  return config;
}

FlightConfig ReadFlightConfig(const fs::path& folder) {
  return ParseFlightConfig(ReadText(folder), folder);
}

}  // namespace dn
