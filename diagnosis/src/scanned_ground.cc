#include "scanned_ground.h"

#include <dn/geo/local_frame.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kMostOfScan = 0.999;  // points beyond are outliers
constexpr double kNarrowestFov_rad = 1.0 * kRadPerDeg;
constexpr double kWidestFov_rad = 150.0 * kRadPerDeg;  // widest that a scenario may have
constexpr double kFlatRelief_m = 3.0;
// Relief of a scenario's ground per standard deviation. The relief bounds a sum of waves.
constexpr double kReliefPerSigma = 8.5;
constexpr double kClearance_m = 15.0;  // a strip below 10 m is rejected
constexpr double kShortestWave_m = 200.0;
constexpr double kLongestWave_m = 5000.0;

double Quantile(std::vector<double> values, double p) {
  const std::ptrdiff_t at = std::lround(p * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

double RootMeanSquare(const std::vector<double>& values, double about) {
  double sum = 0.0;
  for (const double value : values) sum += (value - about) * (value - about);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Directions of the laser vectors relative to the axes of the scanner.
struct ScanAngles {
  std::vector<double> across_rad;  ///< absolute scan angle
  std::vector<double> ahead_rad;   ///< out of the scan plane
  std::vector<double> nadir_rad;   ///< from the nadir axis

  explicit ScanAngles(const Flight& flight) {
    const LidarConfig& lidar = *flight.config.lidar;
    const Vector3d side_s = lidar.scan_axis_s.cross(lidar.nadir_axis_s);
    for (const LidarPair& pair : flight.pairs->pairs) {
      for (const Vector3d& u_s : {pair.u_i_s, pair.u_j_s}) {
        const double down = u_s.dot(lidar.nadir_axis_s);
        across_rad.push_back(std::abs(std::atan2(u_s.dot(side_s), down)));
        ahead_rad.push_back(std::asin(u_s.dot(lidar.scan_axis_s) / u_s.norm()));
        nadir_rad.push_back(std::acos(std::clamp(down / u_s.norm(), -1.0, 1.0)));
      }
    }
  }

  /// Returns whether the scan is a cone, where the angle from nadir is constant.
  bool OnCone() const {
    return RootMeanSquare(nadir_rad, Quantile(nadir_rad, 0.5)) < RootMeanSquare(ahead_rad, 0.0);
  }
};

std::vector<Vector3d> GroundPoints(const Flight& flight, const std::vector<MapPose>& poses,
                                   const Mounting& mounting) {
  std::vector<Vector3d> points_m;
  const auto add = [&](double t_s, const Vector3d& u_s) {
    if (t_s < poses.front().t_s || t_s > poses.back().t_s) return;
    points_m.push_back(Georeference(InterpolatePose(poses, t_s), mounting, u_s));
  };
  for (const LidarPair& pair : flight.pairs->pairs) {
    add(pair.t_i_s, pair.u_i_s);
    add(pair.t_j_s, pair.u_j_s);
  }
  return points_m;
}

double LowestStrip(const std::vector<MapPose>& poses, const std::vector<StripInterval>& strips) {
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const MapPose& pose : poses) {
    for (const StripInterval& strip : strips) {
      if (pose.t_s < strip.t0_s || pose.t_s > strip.t1_s) continue;
      lowest_m = std::min(lowest_m, pose.p_mb.z());
    }
  }
  return lowest_m;
}

/// Returns the extent of the observed ground, which is the longest undulation.
double Extent(const std::vector<Vector3d>& points_m) {
  Vector3d low = points_m.front(), high = points_m.front();
  for (const Vector3d& p : points_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).head<2>().maxCoeff();
}

}  // namespace

LidarScenario EstimateScanner(const Flight& flight, const Mounting& mounting) {
  const LidarConfig& config = *flight.config.lidar;
  LidarScenario lidar;
  lidar.mounting = mounting;
  lidar.scan_axis_s = config.scan_axis_s;
  lidar.nadir_axis_s = config.nadir_axis_s;
  lidar.gsd_m = config.gsd_m.value_or(2.0 * std::sqrt(3.0) * config.sigma_p_m);
  lidar.pulse_rate_hz = 100000.0;  // arbitrary: nothing depends on it
  const ScanAngles angles(flight);
  const bool cone = angles.OnCone();
  lidar.pattern = cone ? ScanPattern::kCone : ScanPattern::kLine;
  const double half_fov_rad =
      cone ? Quantile(angles.nadir_rad, 0.5) : Quantile(angles.across_rad, kMostOfScan);
  lidar.fov_rad = std::clamp(2.0 * half_fov_rad, kNarrowestFov_rad, kWidestFov_rad);
  return lidar;
}

TerrainScenario EstimateGround(const Flight& flight, const Trajectory& trajectory,
                               const Mounting& mounting, const std::vector<StripInterval>& strips) {
  const std::vector<MapPose> poses = trajectory.ToMapPoses(flight.frame);
  const std::vector<Vector3d> points_m = GroundPoints(flight, poses, mounting);
  TerrainScenario ground;
  ground.kind = TerrainKind::kFlat;
  ground.wavelength_m = kShortestWave_m;
  if (points_m.empty()) return ground;
  std::vector<double> height_m;
  for (const Vector3d& p : points_m) height_m.push_back(p.z());
  const double highest_m = LowestStrip(poses, strips) - kClearance_m;
  ground.base_m = std::min(Quantile(height_m, 0.5), highest_m);
  const double sigma_m = 0.5 * (Quantile(height_m, 0.84) - Quantile(height_m, 0.16));
  const double relief_m = std::min(kReliefPerSigma * sigma_m, 2.0 * (highest_m - ground.base_m));
  if (!(relief_m >= kFlatRelief_m)) return ground;
  ground.kind = TerrainKind::kMixed;
  ground.relief_m = relief_m;
  ground.wavelength_m = std::clamp(Extent(points_m), kShortestWave_m, kLongestWave_m);
  return ground;
}

}  // namespace dn
