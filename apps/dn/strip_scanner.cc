#include "strip_scanner.h"

#include <dn/error.h>
#include <dn/files/strip_files.h>
#include <dn/geo/local_frame.h>
#include <dn/lidar/strip_io.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr std::size_t kPointsPerStrip = 100000;
constexpr std::string_view kPrefix = "strips_";

Vector3d MainAxis(const Vector3d& v) {
  Eigen::Index axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return (v[axis] < 0.0 ? -1.0 : 1.0) * Vector3d::Unit(axis);
}

/// Returns laser vectors from the beginning of all strips. The commands that read strips report
/// those that cannot be read.
std::vector<Vector3d> FirstVectors(const std::vector<fs::path>& strips) {
  std::vector<Vector3d> vectors;
  for (const fs::path& file : strips) {
    try {
      const auto strip = OpenStrip(file);
      if (!strip->has_vectors()) continue;
      std::size_t points = 0;
      for (StripCloud cloud; points < kPointsPerStrip && strip->Next(&cloud);) {
        points += cloud.size();
        vectors.insert(vectors.end(), cloud.u_s.begin(), cloud.u_s.end());
      }
    } catch (const InvalidInput&) {
      continue;
    }
  }
  return vectors;
}

}  // namespace

ScannerAxes LaserVectorSums::Axes() const {
  ScannerAxes axes;
  axes.nadir_s = MainAxis(sum_);
  const Vector3d across = squares_ + 1e12 * axes.nadir_s.cwiseAbs();
  Eigen::Index least = 0;
  across.minCoeff(&least);
  axes.scan_s = Vector3d::Unit(least);
  return axes;
}

std::vector<StripScanner> FindStripFolders(const fs::path& flight_folder) {
  std::vector<StripScanner> found;
  const auto add = [&](const std::string& name, std::vector<fs::path> strips) {
    if (!strips.empty()) found.push_back({name, std::move(strips), {}, 0.0, 0.0});
  };
  add("", FindStripFiles(flight_folder, ""));
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(flight_folder, error), end; at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code none;
    if (!name.starts_with(kPrefix) || name == kPrefix || !at->is_directory(none)) continue;
    names.push_back(name.substr(kPrefix.size()));
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) add(name, FindStripFiles(flight_folder, name));
  return found;
}

bool SettleAxes(StripScanner* scanner) {
  const std::vector<Vector3d> vectors = FirstVectors(scanner->strips);
  if (vectors.empty()) return false;
  LaserVectorSums sums;
  for (const Vector3d& u_s : vectors) sums.Add(u_s);
  scanner->axes = sums.Axes();
  const Vector3d across_s = scanner->axes.scan_s.cross(scanner->axes.nadir_s);
  double low_rad = std::numeric_limits<double>::infinity(), high_rad = -low_rad;
  for (const Vector3d& u_s : vectors) {
    const double angle_rad = std::atan2(u_s.dot(across_s), u_s.dot(scanner->axes.nadir_s));
    low_rad = std::min(low_rad, angle_rad);
    high_rad = std::max(high_rad, angle_rad);
  }
  scanner->low_deg = low_rad * kDegPerRad;
  scanner->high_deg = high_rad * kDegPerRad;
  return true;
}

}  // namespace dn::apps
