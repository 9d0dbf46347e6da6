#include "trajectory_content.h"

#include <dn/median.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "plausible_motion.h"

namespace dn::files_internal {
namespace {

using Attitude = TrajectoryColumns::Attitude;

// A slower body has no defined course.
constexpr double kLeastSpeedMps = 3.0;
constexpr double kLeastMoveM = 1.0;
// The heading differs from the course by at most this (wind and mounting of the sensor included) in
// at least kLeastCourseAgreement of the rows.
constexpr double kNearCourse = std::numbers::pi / 4.0;
// Cosine of the largest mean tilt of an aircraft or a vehicle: 60 deg.
constexpr double kLeastUpright = 0.5;
constexpr std::size_t kFewestRows = 20;
constexpr double kMostHeightM = 2e4;
constexpr double kLeastEarthRadiusM = 6.33e6, kMostEarthRadiusM = 6.40e6;
// UTM eastings have six digits before the point, northings up to seven.
constexpr double kLeastEastingM = 1e5, kMostEastingM = 9e5, kMostNorthingM = 1e7;
constexpr double kMostMapM = 1e5;

Eigen::Vector3d Position(const TextTable& table, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3d>(table.row(i) + 1);
}

/// Returns the motion from one position to another, m, east, north, up, for each coordinate system
/// of a trajectory.
Eigen::Vector3d MoveEnu(const std::string& crs, const Eigen::Vector3d& from,
                        const Eigen::Vector3d& to) {
  Eigen::Vector3d by = to - from;
  if (crs == "geographic") {
    const double cos_lat = std::cos(from.x() / 180.0 * std::numbers::pi);
    return {by.y() * kMetresPerDeg * cos_lat, by.x() * kMetresPerDeg, by.z()};
  }
  if (crs != "ecef") return by;
  const Eigen::Vector3d up = from.normalized();
  const Eigen::Vector3d east = Eigen::Vector3d::UnitZ().cross(up).normalized();
  return {by.dot(east), by.dot(up.cross(east)), by.dot(up)};
}

/// Returns whether a position has a plausible size for a coordinate system.
bool HasPlausibleSize(const std::string& crs, const Eigen::Vector3d& p) {
  if (crs == "ecef") return p.norm() > kLeastEarthRadiusM && p.norm() < kMostEarthRadiusM;
  if (std::abs(p.z()) > kMostHeightM) return false;
  if (crs == "geographic") return std::abs(p.x()) <= 90.0 && std::abs(p.y()) <= 360.0;
  if (crs == "utm:") {
    return p.x() > kLeastEastingM && p.x() < kMostEastingM && p.y() >= 0.0 &&
           p.y() < kMostNorthingM;
  }
  return std::abs(p.x()) < kMostMapM && std::abs(p.y()) < kMostMapM;
}

bool IsPossible(const std::string& crs, const TextTable& table) {
  std::vector<double> speeds_mps;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!HasPlausibleSize(crs, Position(table, i))) return false;
    if (i == 0) continue;
    const double step_s = table.row(i)[0] - table.row(i - 1)[0];
    if (!(step_s > 0.0)) continue;
    speeds_mps.push_back(MoveEnu(crs, Position(table, i - 1), Position(table, i)).norm() / step_s);
  }
  return !speeds_mps.empty() && Median(speeds_mps) < kMostSpeedMps;
}

/// Returns the forward direction in east and north from the attitude of a row.
Eigen::Vector2d ForwardEn(const double* attitude, Attitude convention) {
  constexpr double kRad = std::numbers::pi / 180.0;
  if (convention == Attitude::kRollPitchHeading) {
    return {std::sin(attitude[2] * kRad), std::cos(attitude[2] * kRad)};
  }
  if (convention == Attitude::kRollPitchYawEnu) {
    return {std::cos(attitude[2] * kRad), std::sin(attitude[2] * kRad)};
  }
  const Eigen::Quaterniond q(attitude[0], attitude[1], attitude[2], attitude[3]);
  const Eigen::Vector3d forward = q * Eigen::Vector3d::UnitX();
  if (convention == Attitude::kQuaternionEnu) return {forward.x(), forward.y()};
  return {forward.y(), forward.x()};
}

/// Returns the share of the moving rows whose forward axis is near the course; nullopt if too few
/// rows move.
std::optional<double> ShareNearCourse(const TextTable& table, const std::string& crs,
                                      Attitude convention) {
  std::size_t moving = 0, near = 0, from = 0;
  for (std::size_t i = 1; i < table.rows(); ++i) {
    const Eigen::Vector2d move_m =
        MoveEnu(crs, Position(table, from), Position(table, i)).head<2>();
    const double step_s = table.row(i)[0] - table.row(from)[0];
    if (move_m.norm() < kLeastMoveM) continue;
    const double speed_mps = move_m.norm() / step_s;
    from = i;
    if (!(speed_mps > kLeastSpeedMps)) continue;
    ++moving;
    const Eigen::Vector2d forward = ForwardEn(table.row(i) + 4, convention);
    if (forward.dot(move_m) > std::cos(kNearCourse) * forward.norm() * move_m.norm()) ++near;
  }
  if (moving < kFewestRows) return std::nullopt;
  return static_cast<double>(near) / static_cast<double>(moving);
}

bool EndsWithUnitQuaternion(const TextTable& table) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double norm = Eigen::Map<const Eigen::Vector4d>(table.row(i) + 4).norm();
    if (std::abs(norm - 1.0) >= 0.01) return false;
  }
  return true;
}

/// Returns the convention for which the attitude agrees better with the course; nullopt if it
/// agrees for none of the two.
std::optional<Attitude> ByCourse(const TextTable& table, const std::string& crs,
                                 const std::array<Attitude, 2>& conventions) {
  double most = kLeastCourseAgreement;
  std::optional<Attitude> best;
  for (const Attitude convention : conventions) {
    const double share = ShareNearCourse(table, crs, convention).value_or(0.0);
    if (share < most) continue;
    most = share;
    best = convention;
  }
  return best;
}

/// Returns the mean third component of the body's z axis for an attitude in quaternions.
double MeanUpright(const TextTable& table) {
  double z = 0.0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double* q = table.row(i) + 4;
    z += (Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Eigen::Vector3d::UnitZ()).z();
  }
  return z / static_cast<double>(table.rows());
}

bool PointsUp(const TextTable& table, Attitude convention) {
  const double z = MeanUpright(table);
  return convention == Attitude::kQuaternionEnu ? z > 0.0 : z < 0.0;
}

std::array<Attitude, 2> Conventions(bool quaternions) {
  if (quaternions) return {Attitude::kQuaternionNed, Attitude::kQuaternionEnu};
  return {Attitude::kRollPitchHeading, Attitude::kRollPitchYawEnu};
}

}  // namespace

std::optional<std::string> FindCoordinateSystem(const TextTable& table) {
  for (const char* crs : {"geographic", "ecef", "utm:", "map"}) {
    if (IsPossible(crs, table)) return crs;
  }
  return std::nullopt;
}

std::optional<TrajectoryColumns> FindTrajectoryColumns(const TextTable& table) {
  if (table.columns != 7 && table.columns != 8) return std::nullopt;
  const bool quaternions = table.columns == 8 && EndsWithUnitQuaternion(table);
  if (table.columns == 8 && !quaternions) return std::nullopt;
  const std::optional<std::string> crs = FindCoordinateSystem(table);
  if (!crs) return quaternions ? std::optional(TrajectoryColumns{}) : std::nullopt;
  TrajectoryColumns columns;
  columns.crs = *crs;
  const std::optional<Attitude> moving = ByCourse(table, *crs, Conventions(quaternions));
  if (!moving && !quaternions) return std::nullopt;
  columns.attitude = moving.value_or(Attitude::kQuaternionNed);
  columns.body_is_flu = quaternions && PointsUp(table, columns.attitude);
  return columns;
}

std::optional<double> CourseAgreement(const TextTable& table) {
  const bool quaternions = table.columns == 8;
  const std::optional<std::string> crs = FindCoordinateSystem(table);
  if (!crs || (quaternions && std::abs(MeanUpright(table)) < kLeastUpright)) return std::nullopt;
  std::optional<double> most;
  for (const Attitude convention : Conventions(quaternions)) {
    const std::optional<double> share = ShareNearCourse(table, *crs, convention);
    if (share && share > most) most = share;
  }
  return most;
}

}  // namespace dn::files_internal
