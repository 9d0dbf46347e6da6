#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <system_error>

#include "lower_case.h"

namespace dn {
namespace {

namespace fs = std::filesystem;

bool IsStripName(const fs::path& file) {
  const std::string ending = files_internal::LowerCase(file.extension().string());
  return ending == ".las" || ending == ".laz" || ending == ".txt" || ending == ".csv";
}

constexpr double kSameAngleRad = 1e-6 * kRadPerDeg;

std::string AnglesText(const Eigen::Vector3d& rad) {
  const Eigen::Vector3d deg = rad * kDegPerRad;
  return FormatDouble(deg.x()) + ", " + FormatDouble(deg.y()) + ", " + FormatDouble(deg.z()) +
         " deg";
}

std::string CrsName(const StripCrs& said) {
  const std::string code = said.epsg ? "EPSG:" + std::to_string(*said.epsg) : "";
  return code.empty() ? "'" + said.text + "'" : code;
}

}  // namespace

StripGeoreferencing StripsGeoreferencing(const FlightConfig& config) {
  return {config.lidar->mounting, config.lidar->georeferenced_with_rad};
}

VectorOrigin FindVectorOrigin(const StripReader& strip, const StripGeoreferencing& made_with,
                              const fs::path& file) {
  using Kind = VectorOrigin::Kind;
  if (strip.has_vectors()) return {};
  const auto recorded_rad = strip.boresight_rad();
  const auto& declared_rad = made_with.declared_rad;
  if (recorded_rad && declared_rad &&
      (*recorded_rad - *declared_rad).cwiseAbs().maxCoeff() > kSameAngleRad) {
    throw InvalidConfig("the file records that it was georeferenced with the boresight " +
                            AnglesText(*recorded_rad) + ", but lidar.georeferenced_with says " +
                            AnglesText(*declared_rad) + "; remove the key from flight.yaml",
                        {file.string()});
  }
  if (recorded_rad) return {Kind::kRecorded, *recorded_rad};
  if (declared_rad) return {Kind::kDeclared, *declared_rad};
  return {Kind::kAssumed, made_with.mounting.boresight_rad};
}

std::string VectorWarning(const VectorOrigin& origin, const std::string& strip) {
  if (origin.kind != VectorOrigin::Kind::kAssumed) return {};
  return strip + " has no laser vectors: they are computed from its points with the boresight " +
         AnglesText(origin.boresight_rad) +
         " of lidar.boresight_deg, and are wrong if the points were georeferenced with another; "
         "state it in flight.yaml, lidar.georeferenced_with: {boresight_deg: [roll, pitch, yaw]}";
}

namespace {

std::vector<fs::path> FindClouds(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const bool hidden = entry.path().filename().string().starts_with('.');
    if (!hidden && IsStripName(entry.path()) && !IsCircularLink(entry.path())) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

fs::path StripFolder(const fs::path& flight_folder, const std::string& scanner) {
  return flight_folder / (scanner.empty() ? "strips" : "strips_" + scanner);
}

fs::path StripFolder(const FlightConfig& config, std::size_t scanner) {
  return StripFolder(config.folder, config.lidar ? ScannerAt(config, scanner).name : "");
}

}  // namespace

std::vector<fs::path> FindStripFiles(const fs::path& flight_folder) {
  return FindStripFiles(flight_folder, std::string());
}

std::vector<fs::path> FindStripFiles(const fs::path& flight_folder, const std::string& scanner) {
  return FindClouds(StripFolder(flight_folder, scanner));
}

std::vector<fs::path> FindStripFiles(const FlightConfig& config, std::size_t scanner) {
  return FindClouds(StripFolder(config, scanner));
}

std::vector<fs::path> FindStripFiles(const FlightConfig& config) {
  std::vector<fs::path> files = FindStripFiles(config, 0);
  for (std::size_t k = 1; k < NumScanners(config); ++k) {
    const std::vector<fs::path> more = FindStripFiles(config, k);
    files.insert(files.end(), more.begin(), more.end());
  }
  return files;
}

std::vector<fs::path> RequireStripFiles(const FlightConfig& config) {
  std::vector<fs::path> files = FindStripFiles(config);
  if (!files.empty()) return files;
  throw InvalidInput(
      "the flight has no strips; put point clouds (.las, .laz, or .txt of t, x, y, z, ux, uy, uz) "
      "into " +
      StripFolder(config, 0).string());
}

std::string CheckStripCrs(const StripCrs& said, const std::string& strips_crs,
                          const fs::path& file) {
  const FileLocation where{file.string()};
  if (strips_crs == "none") return {};
  if (!said.name.empty() && !IsSameCrs(said.name, strips_crs)) {
    throw InvalidConfig("the points are in " + CrsName(said) +
                            ", but strips_crs of flight.yaml is " + strips_crs +
                            "; write strips_crs: " + said.name + ", or remove the key",
                        where);
  }
  if (said.name.empty() && said.epsg && strips_crs == "map") {
    throw InvalidConfig(
        "the points are in " + CrsName(said) +
            ", but strips_crs of flight.yaml is map; convert them to UTM or another projected "
            "system, and write strips_crs: utm:ZONEn or epsg:CODE",
        where);
  }
  if (said.heights_from_geoid) {
    return "by the header of " + file.filename().string() +
           ", its heights refer to a vertical datum; they are used as ellipsoidal heights" +
           (said.why_not.empty() ? "" : " (" + said.why_not + ")");
  }
  if (said.name.empty() && said.epsg) {
    return "by the header of " + file.filename().string() + ", its points are in " + CrsName(said) +
           "; they are used as " + strips_crs;
  }
  return {};
}

std::string FindStripsCrs(const FlightConfig& config) {
  std::string found;
  for (const fs::path& file : FindStripFiles(config)) {
    try {
      const std::string name = OpenStrip(file)->crs().name;
      if (name.empty() || (!found.empty() && !IsSameCrs(name, found))) return {};
      found = name;
    } catch (const std::exception&) {
      return {};  // reading the strips will name the damage
    }
  }
  return found;
}

}  // namespace dn
