#include "replay.h"

#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace dn {
namespace {

constexpr double kReplayStep_s = 0.25;
constexpr double kLongestHole_s = 1.0;
constexpr double kShortestFlight_s = 10.0;
constexpr double kShortestStrip_s = 10.0;
constexpr double kStraightRate_radps = 0.5 * std::numbers::pi / 180.0;
constexpr double kLevelBank_rad = 8.0 * std::numbers::pi / 180.0;
constexpr double kMovingSpeed_mps = 3.0;
constexpr double kCourseWindow_s = 5.0;

void CheckHoles(const Trajectory& trajectory) {
  const auto& points = trajectory.points();
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].t_s - points[i - 1].t_s > kLongestHole_s) {
      throw InvalidInput("the trajectory to replay has a gap from " +
                         FormatDouble(points[i - 1].t_s) + " to " + FormatDouble(points[i].t_s) +
                         " s; gaps of at most 1 s are allowed");
    }
  }
  if (trajectory.t_end_s() - trajectory.t_begin_s() < kShortestFlight_s) {
    throw InvalidInput("the trajectory to replay is shorter than 10 s");
  }
}

UniformSpline::Vector SplinePoint(const MapPose& pose, const LocalFrame& frame,
                                  std::optional<double> heading_before) {
  const Eigen::Quaterniond q_nm(frame.R_mn(pose.p_mb).transpose());
  Eigen::Vector3d rph = RollPitchHeading(q_nm * pose.q_mb);
  if (heading_before) {
    rph.z() = *heading_before + std::remainder(rph.z() - *heading_before, 2.0 * std::numbers::pi);
  }
  UniformSpline::Vector c;
  c << pose.p_mb, rph;
  return c;
}

/// Returns the straight and level parts of the path that are long enough for a strip.
std::vector<Eigen::Vector2d> FindStraights(const UniformSpline& path, double duration_s) {
  std::vector<Eigen::Vector2d> strips_s;
  double begin_s = 0.0;
  bool inside = false;
  const auto course = [&](double t_s) {
    const UniformSpline::Sample s = path.At(std::clamp(t_s, 0.0, duration_s));
    return std::atan2(s.first.x(), s.first.y());
  };
  for (double t_s = 0.0; t_s <= duration_s; t_s += kReplayStep_s) {
    const UniformSpline::Sample s = path.At(t_s);
    const double turned =
        std::remainder(course(t_s + 0.5 * kCourseWindow_s) - course(t_s - 0.5 * kCourseWindow_s),
                       2.0 * std::numbers::pi);
    const bool straight = std::abs(turned) < kCourseWindow_s * kStraightRate_radps &&
                          std::abs(s.value[3]) < kLevelBank_rad &&
                          s.first.head<2>().norm() > kMovingSpeed_mps;
    if (straight && !inside) begin_s = t_s;
    const bool ends = inside && (!straight || t_s + kReplayStep_s > duration_s);
    if (ends && t_s - begin_s >= kShortestStrip_s) strips_s.emplace_back(begin_s, t_s);
    inside = straight;
  }
  return strips_s;
}

}  // namespace

FlightPlan ReplayFlight(const Trajectory& trajectory, const LocalFrame& frame) {
  CheckHoles(trajectory);
  const std::vector<MapPose> poses = trajectory.ToMapPoses(frame);
  const double span_s = trajectory.t_end_s() - trajectory.t_begin_s();
  std::vector<UniformSpline::Vector> control;
  std::optional<double> heading_before;
  for (int i = 0; i * kReplayStep_s <= span_s; ++i) {
    const MapPose pose = InterpolatePose(poses, trajectory.t_begin_s() + i * kReplayStep_s);
    control.push_back(SplinePoint(pose, frame, heading_before));
    heading_before = control.back()[5];
  }
  const double spline_s = kReplayStep_s * static_cast<double>(control.size());
  const double duration_s = std::floor(spline_s - 2.0 * kReplayMargin_s);
  UniformSpline path(-kReplayMargin_s, kReplayStep_s, std::move(control));
  std::vector<Eigen::Vector2d> strips_s = FindStraights(path, duration_s);
  return {std::move(path), duration_s, 1.0, std::move(strips_s)};
}

}  // namespace dn
