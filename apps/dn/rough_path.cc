#include "rough_path.h"

#include <algorithm>
#include <cmath>

namespace dn::apps {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLongestGap_s = 3.0;
constexpr double kLeastSpeed_mps = 2.0;  // below it, the course is that of noise

/// Returns the attitude of a level body (forward, right, down) that moves with this velocity.
Eigen::Quaterniond LevelAlong(const Vector3d& v_m) {
  const Vector3d down = -Vector3d::UnitZ();
  const Vector3d forward = Vector3d(v_m.x(), v_m.y(), 0.0).normalized();
  Matrix3d R_mb;
  R_mb << forward, down.cross(forward), down;
  return Eigen::Quaterniond(R_mb);
}

}  // namespace

std::optional<MapPose> RoughPath::At(double t_s) const {
  if (!std::isfinite(t_s)) return std::nullopt;
  const auto later = std::ranges::lower_bound(poses, t_s, {}, &MapPose::t_s);
  if (later == poses.end() || (later == poses.begin() && later->t_s > t_s)) return std::nullopt;
  const double gap_s = later == poses.begin() ? 0.0 : later->t_s - std::prev(later)->t_s;
  if (gap_s > kLongestGap_s) return std::nullopt;
  return InterpolatePose(poses, t_s);
}

RoughPath PathFromGnss(const MapGnss& gnss, const LocalFrame& frame) {
  RoughPath path{frame, {}, true};
  for (std::size_t k = 1; k + 1 < gnss.epochs.size(); ++k) {
    const MapGnssEpoch &before = gnss.epochs[k - 1], &after = gnss.epochs[k + 1];
    const double span_s = after.t_s - before.t_s;
    if (span_s > 2.0 * kLongestGap_s) continue;
    const Vector3d v_m = (after.p_m - before.p_m) / span_s;
    if (v_m.head<2>().norm() < kLeastSpeed_mps) continue;
    path.poses.push_back({gnss.epochs[k].t_s, LevelAlong(v_m), gnss.epochs[k].p_m, v_m});
  }
  return path;
}

}  // namespace dn::apps
