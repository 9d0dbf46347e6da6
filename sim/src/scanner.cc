#include "scanner.h"

#include <cmath>
#include <utility>

#include "beams.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kOnPlane_m = 1e-9;
constexpr double kSameTime_s = 1e-10;  // about the resolution of a double for seconds of week
constexpr double kJump_m = 1e-4;
constexpr int kMaxSteps = 60;
// Range difference; a surface this close does not hide the point.
constexpr double kNearSurface_m = 0.3;

Eigen::Matrix3d Rotation(const Vector3d& phi) {
  const double angle = phi.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

}  // namespace

Scanner::Scanner(const LidarScenario& lidar, const ActiveEffects& effects, const LidarSpan& span,
                 std::shared_ptr<const TruthTrajectory> truth,
                 std::shared_ptr<const Terrain> terrain)
    : truth_(std::move(truth)),
      terrain_(std::move(terrain)),
      lidar_(lidar),
      mounting_(lidar.mounting),
      effects_(effects),
      span_(span),
      constant_R_bs_(Rotation(lidar.mounting.boresight_rad) * lidar.mounting.R_bs_nominal),
      scan_axis_s_(lidar.scan_axis_s.normalized()),
      nadir_axis_s_(lidar.nadir_axis_s.normalized()),
      pattern_(lidar.pattern),
      half_fov_rad_(0.5 * lidar.fov_rad) {
  mounting_.lever_arm_b_m += effects.lidar_lever_arm_b_m;
}

Eigen::Matrix3d Scanner::R_bs(double t_s) const {
  if (effects_.boresight_rad.empty()) return constant_R_bs_;
  Vector3d boresight_rad = mounting_.boresight_rad;
  for (const auto& more_rad : effects_.boresight_rad) boresight_rad += more_rad(t_s, span_);
  return Rotation(boresight_rad) * mounting_.R_bs_nominal;
}

/// Returns the distance of the point ahead of the beams, towards +scan_axis.
double Scanner::Ahead(const Vector3d& u_s, int beam) const {
  const double ahead_m = u_s.dot(scan_axis_s_);
  double lean_rad = ScanLean(effects_, lidar_, u_s);
  if (beam != kNoBeam) lean_rad += TrueBeamAngle(lidar_.beams, beam);
  return lean_rad == 0.0 ? ahead_m : ahead_m - std::sin(lean_rad) * u_s.norm();
}

double Scanner::InsideCone(const Vector3d& u_s) const {
  const Vector3d measured_s = TurnedTowardAxis(scan_axis_s_, -ScanLean(effects_, lidar_, u_s), u_s);
  return measured_s.dot(nadir_axis_s_) - std::cos(half_fov_rad_) * u_s.norm();
}

Vector3d Scanner::VectorTo(const Vector3d& point_m, const MapPose& pose) const {
  const Eigen::Matrix3d R_mb = pose.q_mb.toRotationMatrix();
  return R_bs(pose.t_s).transpose() *
         (R_mb.transpose() * (point_m - pose.p_mb) - mounting_.lever_arm_b_m);
}

std::optional<MapPose> Scanner::Swept(const FromBeams& from_beams, const Vector3d& point_m,
                                      const MapPose& first, const MapPose& last) const {
  const auto distance_m = [&](const MapPose& pose) { return from_beams(VectorTo(point_m, pose)); };
  double g0 = distance_m(first), g1 = distance_m(last);
  if (g0 * g1 > 0.0) return std::nullopt;
  double t0_s = first.t_s;
  MapPose latest = last;
  for (int step = 0; step < kMaxSteps && std::abs(latest.t_s - t0_s) > kSameTime_s; ++step) {
    const double t1_s = latest.t_s;
    latest = truth_->Pose(t1_s - g1 * (t1_s - t0_s) / (g1 - g0));
    const double g = distance_m(latest);
    if (std::abs(g) < kOnPlane_m) return latest;
    if (g * g1 < 0.0) {
      t0_s = t1_s;
      g0 = g1;
    } else {
      g0 *= 0.5;  // Illinois method: halving the other end keeps the secant method from stalling
    }
    g1 = g;
  }
  if (std::abs(g1) > kJump_m) return std::nullopt;  // the boresight steps over the point
  return latest;
}

/// Returns the poses at which the beams pass the point. A cone passes it once on each side of the
/// plane that is perpendicular to the direction of travel.
std::vector<MapPose> Scanner::AllSwept(const Vector3d& point_m, const MapPose& first,
                                       const MapPose& last, int beam) const {
  const auto ahead = [&](const Vector3d& u_s) { return Ahead(u_s, beam); };
  const std::optional<MapPose> abeam = Swept(ahead, point_m, first, last);
  std::vector<MapPose> poses;
  if (pattern_ != ScanPattern::kCone) {
    if (abeam) poses.push_back(*abeam);
    return poses;
  }
  const auto inside = [&](const Vector3d& u_s) { return InsideCone(u_s); };
  const MapPose turn = abeam.value_or(last);
  for (const auto& [from, to] : {std::pair(first, turn), std::pair(turn, last)}) {
    if (from.t_s == to.t_s) continue;
    const auto pose = Swept(inside, point_m, from, to);
    if (pose) poses.push_back(*pose);
  }
  return poses;
}

bool Scanner::InView(const Vector3d& u_s) const {
  if (pattern_ == ScanPattern::kCone) return true;
  const double angle =
      std::atan2(u_s.dot(scan_axis_s_.cross(nadir_axis_s_)), u_s.dot(nadir_axis_s_));
  return std::abs(angle) <= half_fov_rad_;
}

bool Scanner::Hidden(const Vector3d& point_m, const MapPose& pose) const {
  const Vector3d origin_m = pose.p_mb + pose.q_mb * mounting_.lever_arm_b_m;
  const Vector3d ray_m = point_m - origin_m;
  const double range_m = ray_m.norm();
  return terrain_->Intersect(origin_m, ray_m / range_m, range_m - kNearSurface_m).has_value();
}

std::vector<Sighting> Scanner::See(const Vector3d& point_m, const MapPose& first,
                                   const MapPose& last, int beam) const {
  std::vector<Sighting> seen;
  for (const MapPose& pose : AllSwept(point_m, first, last, beam)) {
    const Vector3d u_s = VectorTo(point_m, pose);
    if (InView(u_s) && !Hidden(point_m, pose)) seen.push_back({pose.t_s, u_s, beam});
  }
  return seen;
}

}  // namespace dn
