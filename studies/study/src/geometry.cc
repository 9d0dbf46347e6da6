#include "geometry.h"

#include <dn/geo/nearest_pose.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dn {
namespace {

constexpr double kParallelRad = 15.0 * kRadPerDeg;
constexpr double kSameHeight = 0.15;
constexpr double kSameSpeed = 0.1;

/// Returns the mean height of the body above the points of pairs, over the ends of pairs within a
/// strip; 0 without pairs.
double HeightAboveGround(const StudyDesign& design, const StripInterval& strip) {
  const Eigen::Matrix3d R_bs_nominal = design.flight.config.lidar->mounting.R_bs_nominal;
  double sum_m = 0.0;
  long n = 0;
  const auto add = [&](double t_s, const Eigen::Vector3d& u_s) {
    if (t_s < strip.t0_s || t_s > strip.t1_s) return;
    sum_m -= (NearestPose(design.states.poses, t_s).q_mb * (R_bs_nominal * u_s)).z();
    ++n;
  };
  for (const LidarPair& pair : design.flight.pairs->pairs) {
    add(pair.t_i_s, pair.u_i_s);
    add(pair.t_j_s, pair.u_j_s);
  }
  return n > 0 ? sum_m / static_cast<double>(n) : 0.0;
}

StripGeometry ComputeGeometry(const StudyDesign& design, const StripInterval& strip) {
  const std::vector<MapPose>& poses = design.states.poses;
  const Eigen::Vector3d way =
      NearestPose(poses, strip.t1_s).p_mb - NearestPose(poses, strip.t0_s).p_mb;
  StripGeometry geometry;
  geometry.name = strip.name;
  geometry.course_rad = std::atan2(way.x(), way.y());
  geometry.speed_mps = way.norm() / std::max(strip.t1_s - strip.t0_s, 1e-3);
  geometry.height_m = HeightAboveGround(design, strip);
  return geometry;
}

/// Returns the turn between two courses, in (-pi, pi].
double Turn(const StripGeometry& a, const StripGeometry& b) {
  return std::remainder(b.course_rad - a.course_rad, 2.0 * std::numbers::pi);
}

bool Parallel(const StripGeometry& a, const StripGeometry& b) {
  return std::abs(std::sin(Turn(a, b))) < std::sin(kParallelRad);
}

bool Opposite(const StripGeometry& a, const StripGeometry& b) {
  return std::abs(Turn(a, b)) > std::numbers::pi - kParallelRad;
}

template <class Get>
bool Alike(const std::vector<StripGeometry>& strips, double share, const Get& get) {
  double low = get(strips.front()), high = low, sum = 0.0;
  for (const StripGeometry& strip : strips) {
    low = std::min(low, get(strip));
    high = std::max(high, get(strip));
    sum += get(strip);
  }
  return high - low < share * sum / static_cast<double>(strips.size());
}

}  // namespace

FlightGeometry ComputeGeometry(const StudyDesign& design) {
  FlightGeometry geometry;
  for (const StripInterval& strip : design.strips) {
    geometry.strips.push_back(ComputeGeometry(design, strip));
  }
  const std::vector<StripGeometry>& strips = geometry.strips;
  if (strips.empty()) return geometry;
  const auto any_pair = [&](const auto& test) {
    return std::any_of(strips.begin(), strips.end(), [&](const StripGeometry& a) {
      return std::any_of(strips.begin(), strips.end(),
                         [&](const StripGeometry& b) { return test(a, b); });
    });
  };
  geometry.parallel = !any_pair([](const auto& a, const auto& b) { return !Parallel(a, b); });
  geometry.one_direction = !any_pair(Opposite);
  geometry.one_height =
      Alike(strips, kSameHeight, [](const StripGeometry& strip) { return strip.height_m; });
  geometry.one_speed =
      Alike(strips, kSameSpeed, [](const StripGeometry& strip) { return strip.speed_mps; });
  return geometry;
}

}  // namespace dn
