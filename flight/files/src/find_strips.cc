#include <dn/files/flight.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr double kHoleBetweenStripsS = 5.0;
constexpr double kHalfWindowS = 5.0;  // the course is compared over twice this time
// Largest change of the course within the window; a turn of 3 deg/s changes it by 0.5 rad.
constexpr double kMaxCourseChangeRad = 0.1;
constexpr double kMinSpeedMps = 0.5;  // a slower body has no defined course
constexpr double kMinStripS = 10.0;

std::vector<StripInterval> Named(std::vector<StripInterval> strips) {
  for (std::size_t i = 0; i < strips.size(); ++i) strips[i].name = std::to_string(i + 1);
  return strips;
}

/// Returns intervals of sorted epochs without gaps.
std::vector<StripInterval> Clusters(const std::vector<double>& t_s) {
  std::vector<StripInterval> strips;
  for (const double t : t_s) {
    if (strips.empty() || t - strips.back().t1_s > kHoleBetweenStripsS) {
      strips.push_back({"", t, t});
    }
    strips.back().t1_s = t;
  }
  return strips;
}

std::vector<StripInterval> FromPairs(const std::vector<LidarPair>& pairs) {
  std::vector<double> t_s;
  t_s.reserve(2 * pairs.size());
  for (const LidarPair& pair : pairs) {
    t_s.push_back(pair.t_i_s);
    t_s.push_back(pair.t_j_s);
  }
  std::sort(t_s.begin(), t_s.end());
  return Named(Clusters(t_s));
}

/// Returns the angle between two horizontal velocities, rad; pi if one of them is too slow.
double CourseChange(const NavPoint& a, const NavPoint& b) {
  const Eigen::Vector2d u = a.v_ned_mps.head<2>();
  const Eigen::Vector2d v = b.v_ned_mps.head<2>();
  if (u.norm() < kMinSpeedMps || v.norm() < kMinSpeedMps) return std::acos(-1.0);
  return std::abs(std::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v)));
}

/// Returns the epochs around which the course is constant.
std::vector<double> StraightEpochs(const std::vector<NavPoint>& points) {
  std::vector<double> t_s;
  std::size_t first = 0;
  std::size_t last = 0;
  for (const NavPoint& point : points) {
    while (points[first].t_s < point.t_s - kHalfWindowS) ++first;
    while (last + 1 < points.size() && points[last + 1].t_s <= point.t_s + kHalfWindowS) ++last;
    if (CourseChange(points[first], points[last]) < kMaxCourseChangeRad &&
        CourseChange(points[first], point) < kMaxCourseChangeRad) {
      t_s.push_back(point.t_s);
    }
  }
  return t_s;
}

}  // namespace

std::vector<StripInterval> FindStrips(const Trajectory& trajectory) {
  std::vector<StripInterval> strips = Clusters(StraightEpochs(trajectory.points()));
  std::erase_if(strips, [](const StripInterval& s) { return s.t1_s - s.t0_s < kMinStripS; });
  return Named(strips);
}

std::vector<StripInterval> FindStrips(const Flight& flight) {
  if (!flight.config.strips.empty()) return flight.config.strips;
  if (!flight.pair_strips.empty()) return flight.pair_strips;
  if (flight.pairs && !flight.pairs->pairs.empty()) return FromPairs(flight.pairs->pairs);
  if (flight.trajectory) return FindStrips(*flight.trajectory);
  return {};
}

}  // namespace dn
