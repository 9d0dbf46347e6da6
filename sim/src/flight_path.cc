#include "flight_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace dn {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kNoTurn = 1e-9;  // rad; a turn within this of a full circle counts as no turn

Vector2d Right(double heading) { return {std::cos(heading), -std::sin(heading)}; }
double VectorHeading(const Vector2d& d) { return std::atan2(d.x(), d.y()); }
/// Returns the heading of travel at a point from the unit vector to the right.
double HeadingFromRight(const Vector2d& right) { return std::atan2(-right.y(), right.x()); }

/// Returns the angle between two headings when turning to `side` (+1 right, -1 left), in [0, 2 pi).
double Turned(double from, double to, double side) {
  double angle = std::fmod(side * (to - from), kTurn);
  if (angle < 0.0) angle += kTurn;
  return angle > kTurn - kNoTurn ? 0.0 : angle;
}

Vector2d Centre(const Waypoint& w, double side, double radius_m) {
  return w.en_m + side * radius_m * Right(w.heading_rad);
}

std::optional<std::vector<PathPiece>> ArcLineArc(const Waypoint& from, const Waypoint& to,
                                                 double radius_m, double side0, double side1) {
  const Vector2d d = Centre(to, side1, radius_m) - Centre(from, side0, radius_m);
  const double crossing_m = side0 == side1 ? 0.0 : 2.0 * radius_m;
  if (d.norm() < crossing_m) return std::nullopt;
  const double line_m = std::sqrt(std::max(0.0, d.squaredNorm() - crossing_m * crossing_m));
  const double heading = VectorHeading(d) + side0 * std::atan2(crossing_m, line_m);
  return std::vector<PathPiece>{
      {radius_m * Turned(from.heading_rad, heading, side0), side0 / radius_m},
      {line_m, 0.0},
      {radius_m * Turned(heading, to.heading_rad, side1), side1 / radius_m}};
}

/// turn: side of the line between the outer centres on which the middle centre lies.
std::optional<std::vector<PathPiece>> ThreeArcs(const Waypoint& from, const Waypoint& to,
                                                double radius_m, double side, double turn) {
  const Vector2d c0 = Centre(from, side, radius_m), c1 = Centre(to, side, radius_m);
  const Vector2d d = c1 - c0;
  const double length_m = d.norm();
  if (length_m > 4.0 * radius_m || length_m == 0.0) return std::nullopt;
  const Vector2d normal = Vector2d(-d.y(), d.x()) / length_m;
  const double offset_m = std::sqrt(4.0 * radius_m * radius_m - 0.25 * length_m * length_m);
  const Vector2d middle = 0.5 * (c0 + c1) + turn * offset_m * normal;
  const double heading0 = HeadingFromRight(side * (c0 - middle).normalized());
  const double heading1 = HeadingFromRight(side * (c1 - middle).normalized());
  return std::vector<PathPiece>{
      {radius_m * Turned(from.heading_rad, heading0, side), side / radius_m},
      {radius_m * Turned(heading0, heading1, -side), -side / radius_m},
      {radius_m * Turned(heading1, to.heading_rad, side), side / radius_m}};
}

}  // namespace

Waypoint Advance(const Waypoint& from, double length_m, double curvature_per_m) {
  const double half = 0.5 * length_m * curvature_per_m;
  const double chord_m = half == 0.0 ? length_m : length_m * std::sin(half) / half;
  const double course = from.heading_rad + half;
  return {from.en_m + chord_m * Vector2d(std::sin(course), std::cos(course)),
          from.heading_rad + 2.0 * half};
}

double Length(const std::vector<PathPiece>& pieces) {
  double sum_m = 0.0;
  for (const PathPiece& piece : pieces) sum_m += piece.length_m;
  return sum_m;
}

std::vector<PathPiece> ShortestPath(const Waypoint& from, const Waypoint& to, double radius_m) {
  std::vector<PathPiece> best;
  const auto consider = [&](const std::optional<std::vector<PathPiece>>& candidate) {
    if (candidate && (best.empty() || Length(*candidate) < Length(best))) best = *candidate;
  };
  for (const double side0 : {-1.0, 1.0}) {
    for (const double side1 : {-1.0, 1.0}) {
      consider(ArcLineArc(from, to, radius_m, side0, side1));
      consider(ThreeArcs(from, to, radius_m, side0, side1));
    }
  }
  return best;
}

}  // namespace dn
