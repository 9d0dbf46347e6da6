#include "strip_scanner.h"

#include <dn/files/strip_files.h>
#include <dn/geo/local_frame.h>
#include <dn/lidar/mounting_fit.h>
#include <dn/lidar/point_spacing.h>
#include <dn/median.h>
#include <dn/rotation.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

#include "strip_points.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

using Source = ShownMounting::Source;

constexpr std::size_t kFewestPoints = 100;
constexpr std::string_view kPrefix = "strips_";
constexpr double kExactRms_m = 0.3;   // of points that this trajectory and these vectors made
constexpr double kRoughShare = 0.15;  // of the range: a level body along the course
constexpr double kMostMedians = 5.0;  // of the distance of a point from where it should be
constexpr int kRounds = 3;
constexpr double kShareOfNoise = 0.001;    // of points in the air or below the ground, on each side
constexpr double kKnownLeverArm_m = 0.02;  // sigma
constexpr double kUsualTurn_rad = 0.09;    // 5 deg: a mounting along the axes, with its boresight
constexpr double kRoughTurn_rad = 0.35;    // 20 deg: the same, with crab angle and pitch

Vector3d MainAxis(const Vector3d& v) {
  Eigen::Index axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return (v[axis] < 0.0 ? -1.0 : 1.0) * Vector3d::Unit(axis);
}

double MeanRange(const PlacedPoints& placed) {
  double sum_m = 0.0;
  for (const PointAndVector& point : placed.points) sum_m += point.q_b_m.norm();
  return sum_m / static_cast<double>(placed.points.size());
}

/// Returns the points without those that lie far from where the mounting puts them.
std::vector<PointAndVector> WithoutOutliers(const std::vector<PointAndVector>& points,
                                            const MountingFit& fit) {
  std::vector<double> off_m;
  for (const PointAndVector& point : points) {
    off_m.push_back((point.q_b_m - fit.R_bs * point.u_s_m - fit.lever_arm_b_m).norm());
  }
  const double most_m = kMostMedians * Median(off_m);
  std::vector<PointAndVector> kept;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (off_m[k] <= most_m) kept.push_back(points[k]);
  }
  return kept;
}

/// Returns the mounting that leads from the laser vectors to the points, if one does.
std::optional<ShownMounting> FindMounting(const PlacedPoints& placed, bool from_course) {
  std::optional<MountingFit> fit = FitMounting(placed.points);
  for (int round = 0; fit && round < kRounds; ++round) {
    fit = FitMounting(WithoutOutliers(placed.points, *fit));
  }
  const double worst_m = from_course ? kRoughShare * MeanRange(placed) : kExactRms_m;
  if (!fit || fit->rms_m > worst_m) return std::nullopt;
  ShownMounting shown;
  shown.rms_m = fit->rms_m;
  const Eigen::Matrix3d axes = NearestAxes(fit->R_bs);
  const Vector3d turn_rad = Log(Eigen::Quaterniond(fit->R_bs * axes.transpose()));
  const bool along_axes = turn_rad.norm() < (from_course ? kRoughTurn_rad : kUsualTurn_rad);
  shown.R_bs = along_axes ? axes : fit->R_bs;
  if (from_course) {
    shown.source = Source::kCourse;
    return shown;
  }
  shown.source = Source::kTrajectory;
  if (along_axes) shown.boresight_rad = turn_rad;
  if (fit->lever_arm_sigma_m.maxCoeff() < kKnownLeverArm_m)
    shown.lever_arm_b_m = fit->lever_arm_b_m;
  return shown;
}

/// Returns a mounting for points without laser vectors. The first axis of the scanner is nadir. The
/// second is the axis about which the beams turn, as they lie in the body.
ShownMounting ChooseMounting(const PlacedPoints& placed, ScannerAxes* axes) {
  LaserVectorSums sums;
  for (const PointAndVector& point : placed.points) sums.Add(point.q_b_m.normalized());
  const ScannerAxes in_body = sums.Axes();
  *axes = {Vector3d::UnitX(), Vector3d::UnitY()};
  ShownMounting shown;
  shown.R_bs << in_body.nadir_s, in_body.scan_s, in_body.nadir_s.cross(in_body.scan_s);
  return shown;
}

/// Sets the range of the beams about the scan axis. `share` of them on each side is left out.
void SetBeamRange(const std::vector<Vector3d>& u_s, double share, StripScanner* scanner) {
  const Vector3d across_s = scanner->axes.scan_s.cross(scanner->axes.nadir_s);
  std::vector<double> angles_rad;
  for (const Vector3d& u : u_s) {
    angles_rad.push_back(std::atan2(u.dot(across_s), u.dot(scanner->axes.nadir_s)));
  }
  std::ranges::sort(angles_rad);
  const auto left_out = static_cast<std::size_t>(share * static_cast<double>(angles_rad.size()));
  scanner->low_deg = angles_rad[left_out] * kDegPerRad;
  scanner->high_deg = angles_rad[angles_rad.size() - 1 - left_out] * kDegPerRad;
}

/// Lets the scan axis point forward, as far as the mounting knows.
void TurnScanAxisForward(StripScanner* scanner) {
  const Vector3d scan_b = scanner->mounting->R_bs * scanner->axes.scan_s;
  Eigen::Index axis = 0;
  scan_b.cwiseAbs().maxCoeff(&axis);
  if (scan_b[axis] < 0.0) scanner->axes.scan_s = -scanner->axes.scan_s;
}

void SettleMounting(const RoughPath& path, const PointCrs& crs, StripPoints* sample,
                    StripScanner* scanner) {
  const PlacedPoints placed = PlaceAbout(path, crs, *sample, 1);
  if (placed.points.size() < kFewestPoints) return;
  if (sample->crs.empty()) scanner->crs = crs.name();
  const double share =
      static_cast<double>(placed.p_m.size()) / static_cast<double>(sample->p_c.size());
  scanner->gsd_m = PointSpacing(placed.p_m, share * sample->points);
  if (!sample->u_s.empty()) {
    scanner->mounting = FindMounting(placed, path.from_course);
    return;
  }
  scanner->mounting = ChooseMounting(placed, &scanner->axes);
  for (const PointAndVector& point : placed.points) {
    sample->u_s.push_back(scanner->mounting->R_bs.transpose() * point.q_b_m);
  }
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
    if (!strips.empty()) found.push_back({name, std::move(strips), {}, 0.0, 0.0, {}, {}, {}});
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

bool SettleScannerByStrips(const RoughPath* path, const std::vector<std::string>& guesses,
                           StripScanner* scanner) {
  StripPoints sample = TakeStripPoints(scanner->strips);
  LaserVectorSums sums;
  for (const Vector3d& u_s : sample.u_s) sums.Add(u_s);
  if (!sample.u_s.empty()) scanner->axes = sums.Axes();
  if (path != nullptr && !path->poses.empty()) {
    const std::optional<PointCrs> crs = FindPointCrs(*path, sample, guesses);
    if (crs) SettleMounting(*path, *crs, &sample, scanner);
  }
  if (sample.u_s.empty()) return false;
  if (scanner->mounting) TurnScanAxisForward(scanner);
  const bool computed = scanner->mounting && scanner->mounting->source == Source::kChosen;
  SetBeamRange(sample.u_s, computed ? kShareOfNoise : 0.0, scanner);
  return true;
}

}  // namespace dn::apps
