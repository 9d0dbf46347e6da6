#include <dn/error.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "trajectory_io.h"

namespace dn {
namespace {

bool IsFinite(const NavPoint& point) {
  return std::isfinite(point.t_s) && std::isfinite(point.position.lat_rad) &&
         std::isfinite(point.position.lon_rad) && std::isfinite(point.position.h_m) &&
         point.q_nb.coeffs().allFinite() && point.v_ned_mps.allFinite() &&
         point.f_b_mps2.allFinite() && point.w_b_radps.allFinite();
}

void ExpectWithin(double t_s, double t_begin_s, double t_end_s) {
  if (t_s >= t_begin_s && t_s <= t_end_s) return;
  throw InvalidInput("time " + FormatDouble(t_s) + " s is outside the trajectory (" +
                     FormatDouble(t_begin_s) + " s to " + FormatDouble(t_end_s) + " s)");
}

/// Interpolates between the two poses around t_s.
MapPose Between(const MapPose& a, const MapPose& b, double t_s) {
  const double D_s = b.t_s - a.t_s;
  const double s = (t_s - a.t_s) / D_s;
  const Eigen::Vector3d chord_m = b.p_mb - a.p_mb;
  const Eigen::Vector3d va_m = D_s * a.v_m, vb_m = D_s * b.v_m;

  MapPose pose;
  pose.t_s = t_s;
  pose.q_mb = a.q_mb.slerp(s, b.q_mb).normalized();
  pose.p_mb = a.p_mb + s * va_m + s * s * (3.0 * chord_m - 2.0 * va_m - vb_m) +
              s * s * s * (va_m + vb_m - 2.0 * chord_m);
  pose.v_m = (va_m + 2.0 * s * (3.0 * chord_m - 2.0 * va_m - vb_m) +
              3.0 * s * s * (va_m + vb_m - 2.0 * chord_m)) /
             D_s;
  return pose;
}

/// Returns the first element later than t_s in a list sorted by time.
template <class Timed>
auto FirstAfter(const std::vector<Timed>& list, double t_s) {
  return std::upper_bound(list.begin(), list.end(), t_s,
                          [](double t, const Timed& timed) { return t < timed.t_s; });
}

}  // namespace

Trajectory::Trajectory(std::vector<NavPoint> points, TrajectoryNotes notes)
    : points_(std::move(points)), notes_(std::move(notes)) {
  if (points_.size() < 2) {
    throw InvalidInput("trajectory has " + std::to_string(points_.size()) +
                       " points, needs at least two");
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto name = [i] { return "trajectory point " + std::to_string(i); };
    if (!IsFinite(points_[i])) throw InvalidInput(name() + " is not finite");
    if (i > 0 && !(points_[i].t_s > points_[i - 1].t_s)) {
      throw InvalidInput(name() + " at " + FormatDouble(points_[i].t_s) +
                         " s is not later than the one before, at " +
                         FormatDouble(points_[i - 1].t_s) + " s");
    }
  }
}

const NavPoint& Trajectory::FirstPointAtOrAfter(double t_s) const {
  const auto at = std::lower_bound(points_.begin(), points_.end() - 1, t_s,
                                   [](const NavPoint& point, double t) { return point.t_s < t; });
  return *at;
}

std::vector<MapPose> Trajectory::ToMapPoses(const LocalFrame& frame) const {
  std::vector<MapPose> poses;
  poses.reserve(points_.size());
  for (const NavPoint& point : points_) poses.push_back(ToMapPose(point, frame));
  return poses;
}

MapPose Trajectory::MapPoseAt(double t_s, const LocalFrame& frame) const {
  ExpectWithin(t_s, t_begin_s(), t_end_s());
  const auto after = FirstAfter(points_, t_s);
  if (after == points_.end()) return ToMapPose(points_.back(), frame);
  return Between(ToMapPose(*(after - 1), frame), ToMapPose(*after, frame), t_s);
}

MapPose InterpolatePose(const std::vector<MapPose>& poses, double t_s) {
  if (poses.empty()) {
    throw InvalidInput("time " + FormatDouble(t_s) +
                       " s is outside the trajectory, which is empty");
  }
  ExpectWithin(t_s, poses.front().t_s, poses.back().t_s);
  const auto after = FirstAfter(poses, t_s);
  return after == poses.end() ? poses.back() : Between(*(after - 1), *after, t_s);
}

NavPoint ToNavPoint(const MapPose& pose, const LocalFrame& frame) {
  NavPoint point;
  point.t_s = pose.t_s;
  point.position = frame.ToGeodetic(pose.p_mb);
  const Eigen::Matrix3d R_nm = (frame.R_me() * R_en(point.position)).transpose();
  point.q_nb = (Eigen::Quaterniond(R_nm) * pose.q_mb).normalized();
  point.v_ned_mps = R_nm * pose.v_m;
  return point;
}

MapPose ToMapPose(const NavPoint& point, const LocalFrame& frame) {
  const Eigen::Matrix3d R_mn = frame.R_me() * R_en(point.position);
  MapPose pose;
  pose.t_s = point.t_s;
  pose.q_mb = (Eigen::Quaterniond(R_mn) * point.q_nb).normalized();
  pose.p_mb = frame.ToMap(point.position);
  pose.v_m = R_mn * point.v_ned_mps;
  return pose;
}

Trajectory ReadTrajectory(const std::filesystem::path& file, const TrajectoryColumns& columns) {
  if (IsBinaryFile(file)) return geo_internal::ReadSbet(file);
  return geo_internal::ReadTrajectoryText(file, columns);
}

}  // namespace dn
