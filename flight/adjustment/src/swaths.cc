#include <dn/adjustment/swaths.h>
#include <dn/files/strip_at.h>
#include <dn/report/json.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kLinePoses = 60;

/// Returns the unit vector to the right of the body's course, east and north.
Vector2d RightDirection(const MapPose& pose) {
  const Eigen::Vector3d ahead_m = pose.q_mb * Eigen::Vector3d::UnitX();
  return Vector2d(ahead_m.y(), -ahead_m.x()).normalized();
}

/// Range of the distances, m, at which the pairs of a strip lie to the right of its line, and their
/// heights.
struct Reach {
  double min_m = 0.0;
  double max_m = 0.0;
  double sum_up_m = 0.0;
  long ends = 0;

  void Add(double right_m, double up_m) {
    min_m = ends > 0 ? std::min(min_m, right_m) : right_m;
    max_m = ends > 0 ? std::max(max_m, right_m) : right_m;
    sum_up_m += up_m;
    ++ends;
  }
};

template <typename Point>
Json Rounded(const std::vector<Point>& points_m) {
  Json list = Json::array();
  const auto to_cm = [](double value_m) { return std::round(value_m * 100.0) / 100.0; };
  for (const Point& p : points_m) list.push_back({to_cm(p.x()), to_cm(p.y())});
  return list;
}

}  // namespace

std::vector<Swath> MakeSwaths(const std::vector<StripInterval>& strips,
                              const std::vector<PairResidual>& pairs,
                              const PoseInterpolator& poses) {
  std::vector<Reach> reaches(strips.size());
  for (const PairResidual& pair : pairs) {
    for (const double t_s : {pair.i.t_s, pair.j.t_s}) {
      const StripInterval* strip = StripAt(strips, t_s);
      if (strip == nullptr) continue;
      const MapPose pose = poses.Nearest(t_s);
      reaches[static_cast<std::size_t>(strip - strips.data())].Add(
          RightDirection(pose).dot((pair.ground_m - pose.p_mb).head<2>()), pair.ground_m.z());
    }
  }
  std::vector<Swath> swaths;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    Swath swath{strips[s].name, {}, {}};
    const Reach& reach = reaches[s];
    if (reach.ends > 0) swath.outline_up_m = reach.sum_up_m / static_cast<double>(reach.ends);
    std::vector<Vector2d> right;
    for (const double t_s : EvenTimes(strips[s].t0_s, strips[s].t1_s, kLinePoses)) {
      const MapPose pose = poses.Nearest(t_s);
      const Vector2d place_en_m = pose.p_mb.head<2>();
      swath.line_m.push_back(pose.p_mb);
      if (reach.ends == 0) continue;
      swath.outline_en_m.emplace_back(place_en_m + reach.min_m * RightDirection(pose));
      right.emplace_back(place_en_m + reach.max_m * RightDirection(pose));
    }
    swath.outline_en_m.insert(swath.outline_en_m.end(), right.rbegin(), right.rend());
    swaths.push_back(std::move(swath));
  }
  return swaths;
}

std::string FormatSwaths(const std::vector<Swath>& swaths) {
  Json list = Json::array();
  for (const Swath& swath : swaths) {
    list.push_back({{"strip", swath.strip},
                    {"line_en_m", Rounded(swath.line_m)},
                    {"outline_en_m", Rounded(swath.outline_en_m)}});
  }
  return Json{{"schema", "dn.swaths/1"}, {"swaths", list}}.dump(-1, ' ', false,
                                                                Json::error_handler_t::replace) +
         "\n";
}

}  // namespace dn
