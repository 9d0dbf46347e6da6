#include <dn/lidar/swath.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dn {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMostStretches = 60;

}  // namespace

const std::array<Vector2d, SwathOutline::kDirections>& SwathOutline::Directions() {
  static const auto directions = [] {
    std::array<Vector2d, kDirections> list;
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double angle_rad =
          2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kDirections);
      list[k] = {std::cos(angle_rad), std::sin(angle_rad)};
    }
    return list;
  }();
  return directions;
}

void SwathOutline::Stretch::Add(const Vector2d& p_en_m) {
  for (std::size_t k = 0; k < kDirections; ++k) {
    Vector2d& outermost = outermost_en_m[k];
    if (points == 0.0 || Directions()[k].dot(p_en_m - outermost) > 0.0) outermost = p_en_m;
  }
  sum_en_m += p_en_m;
  points += 1.0;
}

void SwathOutline::Stretch::Join(const Stretch& other) {
  const double all = points + other.points;
  const Vector2d sum = sum_en_m + other.sum_en_m;
  for (const Vector2d& p_en_m : other.outermost_en_m) Add(p_en_m);
  points = all;
  sum_en_m = sum;
}

const Vector2d& SwathOutline::Stretch::Towards(const Vector2d& direction_en) const {
  const auto& directions = Directions();
  const auto nearest = std::max_element(
      directions.begin(), directions.end(),
      [&](const auto& a, const auto& b) { return a.dot(direction_en) < b.dot(direction_en); });
  return outermost_en_m[static_cast<std::size_t>(nearest - directions.begin())];
}

void SwathOutline::Add(double t_s, const Eigen::Vector3d& p_m) {
  by_second_[std::lround(std::floor(t_s))].Add(p_m.head<2>());
  points_ += 1.0;
  sum_up_m_ += p_m.z();
}

std::vector<SwathOutline::Stretch> SwathOutline::FewStretches() const {
  const std::size_t step = (by_second_.size() + kMostStretches - 1) / kMostStretches;
  std::vector<Stretch> stretches;
  std::size_t k = 0;
  for (const auto& [second, stretch] : by_second_) {
    if (k++ % step == 0) {
      stretches.push_back(stretch);
    } else {
      stretches.back().Join(stretch);
    }
  }
  return stretches;
}

std::vector<Vector2d> SwathOutline::Corners() const {
  const std::vector<Stretch> stretches = FewStretches();
  if (stretches.empty()) return {};
  if (stretches.size() == 1) {
    const auto& all = stretches.front().outermost_en_m;
    return stretches.front().points < 3.0 ? std::vector<Vector2d>()
                                          : std::vector<Vector2d>(all.begin(), all.end());
  }
  std::vector<Vector2d> left, right;
  for (std::size_t k = 0; k < stretches.size(); ++k) {
    const Stretch& before = stretches[k == 0 ? 0 : k - 1];
    const Stretch& after = stretches[std::min(k + 1, stretches.size() - 1)];
    const Vector2d course_en = after.Mean() - before.Mean();
    const Vector2d left_en(-course_en.y(), course_en.x());
    left.push_back(stretches[k].Towards(left_en));
    right.push_back(stretches[k].Towards(-left_en));
  }
  left.insert(left.end(), right.rbegin(), right.rend());
  return left;
}

std::vector<double> EvenTimes(double t0_s, double t1_s, std::size_t count) {
  std::vector<double> times_s;
  for (std::size_t k = 0; k < count; ++k) {
    times_s.push_back(t0_s +
                      (t1_s - t0_s) * static_cast<double>(k) / static_cast<double>(count - 1));
  }
  return times_s;
}

}  // namespace dn
