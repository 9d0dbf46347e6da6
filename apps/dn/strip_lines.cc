#include "strip_lines.h"

#include <dn/files/strip_at.h>
#include <dn/rotation.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace dn::apps {
namespace {

// Smallest angle between crossing lines, as in the Gauss-Helmert assessment.
constexpr double kCrossingRad = 20.0 * kRadPerDeg;
constexpr double kHeightPerRange = 0.05;

struct Point {
  double t_s;
  Geodetic position;
};

std::vector<Point> Points(const Flight& flight) {
  std::vector<Point> points;
  if (flight.trajectory) {
    for (const NavPoint& point : flight.trajectory->points()) {
      points.push_back({point.t_s, point.position});
    }
  } else if (flight.gnss) {
    for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
      points.push_back({epoch.t_s, flight.frame.ToGeodetic(epoch.p_m)});
    }
  }
  return points;
}

StripLine LineFromPoints(const std::vector<Point>& points, const LocalFrame& frame,
                         const StripInterval& strip) {
  StripLine line{strip};
  const auto earlier = [](const Point& point, double t_s) { return point.t_s < t_s; };
  const auto first = std::lower_bound(points.begin(), points.end(), strip.t0_s, earlier);
  const auto end = std::lower_bound(first, points.end(), strip.t1_s, earlier);
  if (end - first < 2) return line;
  line.known = true;
  const Eigen::Vector3d way = frame.ToMap((end - 1)->position) - frame.ToMap(first->position);
  line.length_m = way.head<2>().norm();
  line.course_rad = std::atan2(way.x(), way.y());
  if (line.course_rad < 0.0) line.course_rad += 2.0 * std::numbers::pi;
  for (auto point = first; point != end; ++point) line.height_m += point->position.h_m;
  line.height_m /= static_cast<double>(end - first);
  return line;
}

bool Cross(const StripLine& a, const StripLine& b) {
  return std::abs(std::remainder(a.course_rad - b.course_rad, std::numbers::pi)) >= kCrossingRad;
}

bool Opposite(const StripLine& a, const StripLine& b) {
  return std::cos(a.course_rad - b.course_rad) < 0.0;
}

template <class Test>
bool AnyTwo(const std::vector<StripLine>& lines, const Test& test) {
  return std::any_of(lines.begin(), lines.end(), [&](const StripLine& a) {
    return std::any_of(lines.begin(), lines.end(), [&](const StripLine& b) { return test(a, b); });
  });
}

}  // namespace

std::vector<StripLine> StripLines(const Flight& flight, const std::vector<StripInterval>& strips) {
  const std::vector<Point> points = Points(flight);
  std::vector<StripLine> lines;
  for (const StripInterval& strip : strips)
    lines.push_back(LineFromPoints(points, flight.frame, strip));
  return lines;
}

std::map<std::string, StripPairs> CountStripPairs(const Flight& flight,
                                                  const std::vector<StripInterval>& strips) {
  std::map<std::string, StripPairs> all;
  std::map<std::string, std::set<std::pair<std::string, int>>> tenths;
  for (const LidarPair& pair : flight.pairs->pairs) {
    const auto [t0_s, t1_s] = std::minmax(pair.t_i_s, pair.t_j_s);
    const std::string name = StripPairName(strips, t0_s, t1_s);
    ++all[name].count;
    for (const double t_s : {t0_s, t1_s}) {
      const StripInterval* strip = StripAt(strips, t_s);
      if (strip == nullptr) continue;
      const double share = (t_s - strip->t0_s) / std::max(strip->t1_s - strip->t0_s, 1e-9);
      tenths[name].insert({strip->name, std::min(9, static_cast<int>(10.0 * share))});
    }
  }
  for (auto& [name, pairs] : all) pairs.tenths = static_cast<int>(tenths[name].size());
  return all;
}

std::string DescribeGeometry(const std::vector<StripLine>& lines, double mean_range_m) {
  if (lines.empty() ||
      !std::all_of(lines.begin(), lines.end(), [](const StripLine& line) { return line.known; })) {
    return {};
  }
  if (lines.size() == 1) return "one line: no other line overlaps it";
  const bool crossing = AnyTwo(lines, Cross);
  const bool opposite = AnyTwo(lines, Opposite);
  const bool heights = AnyTwo(lines, [&](const StripLine& a, const StripLine& b) {
    return a.height_m - b.height_m >= kHeightPerRange * mean_range_m;
  });
  const std::string all =
      fmt::format("{} {} lines at {}", lines.size(), crossing ? "crossing" : "parallel",
                  heights ? "different heights" : "one height");
  if (crossing && heights) return all + ": roll, pitch and yaw are separable";
  if (crossing) return all + ": roll, pitch and yaw are separable, a range offset hardly";
  if (!opposite) return all + ", all in one direction: pitch and yaw will be weak";
  return all + (heights || lines.size() >= 4 ? " in both directions: yaw is the weakest"
                                             : ": yaw will be weak");
}

}  // namespace dn::apps
