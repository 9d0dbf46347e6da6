#include <dn/error.h>
#include <dn/names.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "config_sections.h"

namespace dn::files_internal {
namespace {

constexpr double kUnitTolerance = 1e-3;  // allows axes written with three digits
constexpr double kRoundOff = 4e-16;
constexpr double kMaxAngleDeg = 180.0;
constexpr double kMaxCosineOfAxes = 1e-2;  // allows half a degree from a right angle

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

PairSelection ReadSelection(const YamlValue& section) {
  using Strategy = PairSelection::Strategy;
  section.ExpectMap({"strategy", "count", "freq_hz", "window_s", "seed"});
  PairSelection selection;
  if (section["strategy"]) selection.strategy = section["strategy"].Choice(StrategyWords());
  if (section["count"]) selection.count = static_cast<long>(section["count"].Integer(1));
  if (section["freq_hz"]) selection.freq_hz = ReadPositive(section["freq_hz"]);
  if (section["window_s"]) selection.window_s = ReadPositive(section["window_s"]);
  if (section["seed"]) {
    selection.seed = static_cast<std::uint64_t>(section["seed"].Integer(0));
  }
  const auto need = [&](Strategy strategy, bool given, const char* key) {
    if (selection.strategy == strategy && !given) {
      section[key].Fail("is required by strategy " + FindWord(strategy, StrategyWords()));
    }
  };
  need(Strategy::kMax, selection.count.has_value(), "count");
  need(Strategy::kFreq, selection.freq_hz.has_value(), "freq_hz");
  need(Strategy::kTimeWindow, selection.window_s.has_value(), "window_s");
  return selection;
}

Eigen::Vector3d ReadUnitVector(const YamlValue& value) {
  const Eigen::Vector3d axis = ReadVector3(value);
  const double length = axis.norm();
  if (std::abs(length - 1.0) > kUnitTolerance) {
    value.Fail("must be a unit vector, but has length " + Short(length));
  }
  return std::abs(length - 1.0) <= kRoundOff ? axis : Eigen::Vector3d(axis / length);
}

void CheckAxes(const YamlValue& section, const ScannerAxes& axes) {
  const double cosine = axes.scan_axis_s.dot(axes.nadir_axis_s);
  if (std::abs(cosine) > kMaxCosineOfAxes) {
    section["nadir_axis"].Fail("must be perpendicular to scan_axis; their cosine is " +
                               Short(cosine));
  }
  const double down = (axes.R_bs_nominal * axes.nadir_axis_s).z();
  if (!(down > 1e-6)) {
    section["nadir_axis"].Fail(
        "must point below the horizon when mounted; R_sensor_to_body takes it to a downward "
        "component of " +
        Short(down) + " (check nadir_axis, R_sensor_to_body and body)");
  }
}

std::optional<Eigen::Vector3d> ReadBoresightSigma(const YamlValue& value) {
  if (!value) return std::nullopt;
  const Eigen::Vector3d deg = value.IsScalar() ? Eigen::Vector3d::Constant(ReadPositive(value))
                                               : ReadPositiveVector3(value);
  return deg.unaryExpr(&RadFromDeg);
}

/// Reads the word `boresight`, which means the boresight of the section, or {boresight_deg: [roll,
/// pitch, yaw]}.
Eigen::Vector3d ReadGeoreferencing(const YamlValue& value, const Eigen::Vector3d& boresight_rad,
                                   bool body_is_flu) {
  if (value.IsScalar()) {
    if (value.Text() == "boresight") return boresight_rad;
    value.Fail(
        "must be `boresight` (the value of lidar.boresight_deg) or {boresight_deg: [roll, pitch, "
        "yaw]}");
  }
  value.ExpectMap({"boresight_deg"});
  const Eigen::Vector3d deg = ReadVector3(value["boresight_deg"]);
  if (deg.cwiseAbs().maxCoeff() > kMaxAngleDeg) {
    value["boresight_deg"].Fail("must lie within -180 and 180 deg");
  }
  const Eigen::Vector3d rad = deg.unaryExpr(&RadFromDeg);
  return body_is_flu ? FlipBody(rad) : rad;
}

void ReadPairNoise(const YamlValue& section, LidarConfig& lidar) {
  if (section["gsd_m"]) lidar.gsd_m = ReadPositive(section["gsd_m"]);
  if (section["sigma_p_m"]) {
    lidar.sigma_p_m = ReadPositive(section["sigma_p_m"]);
  } else if (lidar.gsd_m) {
    lidar.sigma_p_m = *lidar.gsd_m / 2.0 / std::sqrt(3.0);
    if (lidar.sigma_p_m < kLeastSigmaM) section["gsd_m"].Fail("must be at least 4e-12");
  } else {
    section["sigma_p_m"].Fail(
        "one of lidar.gsd_m (ground sampling distance) and lidar.sigma_p_m (per coordinate of a "
        "pair's difference) is required");
  }
}

}  // namespace

Eigen::Matrix3d ReadRotation(const YamlValue& value) {
  try {
    return CheckedRotation(ReadMatrix3(value));
  } catch (const InvalidConfig&) {
    throw;
  } catch (const InvalidInput& e) {
    value.Fail(e.what());
  }
}

std::vector<std::string> ReadPairPatterns(const YamlValue& list, bool may_be_empty) {
  std::vector<std::string> patterns;
  for (const YamlValue& item : list.Items(kMostPatterns)) patterns.push_back(item.Text());
  if (patterns.empty() && !may_be_empty) list.Fail("must name at least one file");
  return patterns;
}

LidarConfig ReadLidarSection(const YamlValue& section, bool body_is_flu, const std::string& name) {
  std::vector<std::string> keys{"p2p",         "time_offset_s",
                                "pairs",       "R_sensor_to_body",
                                "lever_arm_m", "boresight_deg",
                                "scan_axis",   "boresight_sigma_deg",
                                "nadir_axis",  "georeferenced_with",
                                "gsd_m",       "sigma_p_m",
                                "robust",      "beams"};
  keys.emplace_back(name.empty() ? "surface_pairs" : "name");
  section.ExpectMap(keys);
  const auto to_frd = [&](const Eigen::Vector3d& v) { return body_is_flu ? FlipBody(v) : v; };
  LidarConfig lidar;
  lidar.name = name;
  if (!name.empty()) lidar.p2p = {"lidar_" + name + "/*.txt"};
  if (section["p2p"]) lidar.p2p = ReadPairPatterns(section["p2p"], !name.empty());
  lidar.time_offset_s = ReadTimeOffset(section);
  if (section["pairs"]) lidar.pairs = ReadSelection(section["pairs"]);
  const ScannerAxes axes = ReadScannerAxes(section, body_is_flu);
  lidar.mounting.R_bs_nominal = axes.R_bs_nominal;
  lidar.scan_axis_s = axes.scan_axis_s;
  lidar.nadir_axis_s = axes.nadir_axis_s;
  if (section["lever_arm_m"]) {
    lidar.mounting.lever_arm_b_m = to_frd(ReadVector3(section["lever_arm_m"]));
  }
  if (section["boresight_deg"]) {
    lidar.mounting.boresight_rad =
        to_frd(ReadVector3(section["boresight_deg"]).unaryExpr(&RadFromDeg));
  }
  lidar.boresight_sigma_rad = ReadBoresightSigma(section["boresight_sigma_deg"]);
  if (section["georeferenced_with"]) {
    lidar.georeferenced_with_rad = ReadGeoreferencing(section["georeferenced_with"],
                                                      lidar.mounting.boresight_rad, body_is_flu);
  }
  ReadPairNoise(section, lidar);
  if (section["robust"]) lidar.robust = section["robust"].Choice(RobustWords());
  if (section["beams"]) lidar.beams = ReadBeams(section["beams"]);
  if (const YamlValue files = section["surface_pairs"]) {
    lidar.surface_pairs = ReadPairPatterns(files, true);
    if (lidar.beams && !lidar.surface_pairs.empty()) files.Fail("needs a scanner with one beam");
  }
  return lidar;
}

}  // namespace dn::files_internal

namespace dn {

ScannerAxes ReadScannerAxes(const YamlValue& section, bool body_is_flu) {
  using files_internal::ReadUnitVector;
  ScannerAxes axes;
  const YamlValue matrix = section["R_sensor_to_body"];
  if (matrix) axes.R_bs_nominal = files_internal::ReadRotation(matrix);
  if (body_is_flu) files_internal::FlipBody(&axes.R_bs_nominal);
  if (section["scan_axis"]) axes.scan_axis_s = ReadUnitVector(section["scan_axis"]);
  if (section["nadir_axis"]) axes.nadir_axis_s = ReadUnitVector(section["nadir_axis"]);
  files_internal::CheckAxes(section, axes);
  return axes;
}

void ExpectPlainName(const YamlValue& value, const std::string& name) {
  const bool plain = std::all_of(name.begin(), name.end(),
                                 [](unsigned char c) { return std::isalnum(c) != 0 || c == '-'; });
  if (plain && !name.empty()) return;
  value.Fail("the name '" + name + "' must consist of letters, digits and '-'");
}

std::string ReadScannerName(const YamlValue& item, const std::vector<std::string>& before) {
  const YamlValue value = item["name"];
  std::string name = value ? ReadName(value) : std::to_string(before.size() + 1);
  ExpectPlainName(value, name);
  if (HasName(before, name)) item.Fail("two scanners have the name '" + name + "'");
  return name;
}

}  // namespace dn
