#include "strip_scanner.h"

#include <dn/error.h>
#include <dn/files/strip_files.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>
#include <dn/lidar/mounting_fit.h>
#include <dn/lidar/point_spacing.h>
#include <dn/lidar/strip_io.h>
#include <dn/rotation.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

using Source = ShownMounting::Source;

constexpr std::size_t kPointsPerStrip = 100000;
constexpr std::size_t kEvery = 7;  // takes every seventh point
constexpr std::size_t kFewestPoints = 100;
constexpr std::size_t kPointsOfGuess = 50;
constexpr std::string_view kPrefix = "strips_";
// Largest difference of the distance of a point from the path and the length of its laser vector,
// if both are of the same flight; a share of the length.
constexpr double kRangeTolerance = 0.2;
constexpr double kLongestRange_m = 8000.0;
constexpr double kExactRms_m = 0.3;   // of points that this trajectory and these vectors made
constexpr double kRoughShare = 0.15;  // of the range: a level body along the course
constexpr double kMostMedians = 5.0;  // of the distance of a point from where it should be
constexpr int kRounds = 3;
constexpr double kShareOfNoise = 0.001;    // of points in the air or below the ground, on each side
constexpr double kKnownLeverArm_m = 0.02;  // sigma
constexpr double kUsualTurn_rad = 0.09;    // 5 deg: a mounting along the axes, with its boresight
constexpr double kRoughTurn_rad = 0.35;    // 20 deg: the same, with crab angle and pitch

/// Some points of all strips of a scanner.
struct Sample {
  std::vector<double> t_s;
  std::vector<Vector3d> p_c;
  std::vector<Vector3d> u_s;  ///< empty if a strip lacks them
  bool has_vectors = true;
  std::string crs;      ///< stated by the files
  double points = 0.0;  ///< number before sampling
};

Vector3d MainAxis(const Vector3d& v) {
  Eigen::Index axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return (v[axis] < 0.0 ? -1.0 : 1.0) * Vector3d::Unit(axis);
}

/// Adds points from the beginning of a strip.
void AddPoints(const fs::path& file, Sample* sample) {
  const auto strip = OpenStrip(file);
  sample->has_vectors = sample->has_vectors && strip->has_vectors();
  if (!strip->crs().name.empty()) sample->crs = strip->crs().name;
  std::size_t points = 0;
  for (StripCloud cloud; points < kPointsPerStrip && strip->Next(&cloud); points += cloud.size()) {
    for (std::size_t k = 0; k < cloud.size(); k += kEvery) {
      sample->t_s.push_back(cloud.t_s.empty() ? std::nan("") : cloud.t_s[k]);
      sample->p_c.push_back(cloud.p_c[k]);
      if (strip->has_vectors()) sample->u_s.push_back(cloud.u_s[k]);
    }
  }
  sample->points += static_cast<double>(points);
}

/// Returns points of the strips that can be read; the commands that use strips report the others.
Sample TakeSample(const std::vector<fs::path>& strips) {
  Sample sample;
  for (const fs::path& file : strips) {
    Sample whole = sample;
    try {
      AddPoints(file, &whole);
      sample = std::move(whole);
    } catch (const InvalidInput&) {
      continue;
    }
  }
  if (!sample.has_vectors) sample.u_s.clear();
  return sample;
}

/// The points in body axes, with their laser vectors if they have some.
struct PlacedSample {
  std::vector<PointAndVector> points;
  std::vector<Vector3d> p_m;
};

/// Returns the point in m; nullopt if it is outside of the system.
std::optional<Vector3d> ToMap(const PointCrs& crs, const Vector3d& p_c) {
  try {
    return crs.ToMap(p_c);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

/// Places every `step`-th point about the path. Points without a pose or outside of the system are
/// left out.
PlacedSample PlaceAbout(const RoughPath& path, const PointCrs& crs, const Sample& sample,
                        std::size_t step) {
  PlacedSample placed;
  for (std::size_t k = 0; k < sample.p_c.size(); k += step) {
    const std::optional<MapPose> pose = path.At(sample.t_s[k]);
    const std::optional<Vector3d> p_m = ToMap(crs, sample.p_c[k]);
    if (!pose || !p_m) continue;
    placed.p_m.push_back(*p_m);
    PointAndVector point;
    point.q_b_m = pose->q_mb.conjugate() * (placed.p_m.back() - pose->p_mb);
    if (!sample.u_s.empty()) point.u_s_m = sample.u_s[k];
    placed.points.push_back(point);
  }
  return placed;
}

/// Returns whether points are where a scanner on the path can measure them.
bool LieAbout(const PlacedSample& placed, bool have_vectors) {
  if (placed.points.size() < kPointsOfGuess / 2) return false;
  std::size_t agree = 0;
  for (const PointAndVector& point : placed.points) {
    const double range_m = point.q_b_m.norm(), length_m = point.u_s_m.norm();
    agree += have_vectors ? std::abs(range_m - length_m) < kRangeTolerance * length_m
                          : range_m < kLongestRange_m && point.q_b_m.z() > 0.0;
  }
  return 10 * agree > 9 * placed.points.size();
}

/// Returns the system in which the points lie about the path; nullopt if there is none.
std::optional<PointCrs> FindCrs(const RoughPath& path, const Sample& sample,
                                std::vector<std::string> guesses) {
  if (!sample.crs.empty()) guesses = {sample.crs};
  const std::size_t step = std::max<std::size_t>(1, sample.p_c.size() / kPointsOfGuess);
  for (const std::string& name : guesses) {
    try {
      PointCrs crs(name, path.frame);
      if (LieAbout(PlaceAbout(path, crs, sample, step), !sample.u_s.empty())) return crs;
    } catch (const InvalidInput&) {  // the system does not exist, or needs a grid
      continue;
    }
  }
  return std::nullopt;
}

double MeanRange(const PlacedSample& placed) {
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
  std::vector<double> sorted_m = off_m;
  const auto middle = sorted_m.begin() + static_cast<std::ptrdiff_t>(sorted_m.size() / 2);
  std::ranges::nth_element(sorted_m, middle);
  std::vector<PointAndVector> kept;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (off_m[k] <= kMostMedians * *middle) kept.push_back(points[k]);
  }
  return kept;
}

/// Returns the mounting that leads from the laser vectors to the points, if one does.
std::optional<ShownMounting> FindMounting(const PlacedSample& placed, bool from_course) {
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
ShownMounting ChooseMounting(const PlacedSample& placed, ScannerAxes* axes) {
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

void SettleMounting(const RoughPath& path, const PointCrs& crs, Sample* sample,
                    StripScanner* scanner) {
  const PlacedSample placed = PlaceAbout(path, crs, *sample, 1);
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
  Sample sample = TakeSample(scanner->strips);
  LaserVectorSums sums;
  for (const Vector3d& u_s : sample.u_s) sums.Add(u_s);
  if (!sample.u_s.empty()) scanner->axes = sums.Axes();
  if (path != nullptr && !path->poses.empty()) {
    const std::optional<PointCrs> crs = FindCrs(*path, sample, guesses);
    if (crs) SettleMounting(*path, *crs, &sample, scanner);
  }
  if (sample.u_s.empty()) return false;
  if (scanner->mounting) TurnScanAxisForward(scanner);
  const bool computed = scanner->mounting && scanner->mounting->source == Source::kChosen;
  SetBeamRange(sample.u_s, computed ? kShareOfNoise : 0.0, scanner);
  return true;
}

}  // namespace dn::apps
