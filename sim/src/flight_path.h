#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Point of a path: east, north (m) and heading (rad, clockwise from north).
struct Waypoint {
  Eigen::Vector2d en_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
};

/// Straight line (curvature 0) or circular arc. The curvature is positive to the right.
struct PathPiece {
  double length_m = 0.0;
  double curvature_per_m = 0.0;
};

/// Returns the waypoint after `length_m` along a piece of the given curvature. The heading is
/// continued and not wrapped.
Waypoint Advance(const Waypoint& from, double length_m, double curvature_per_m);

/// Returns the shortest path of arcs of radius_m and straight lines from one waypoint to another
/// (Dubins, 1957): arc-line-arc, or three arcs. The heading at its end equals that of `to` up to
/// full turns.
std::vector<PathPiece> ShortestPath(const Waypoint& from, const Waypoint& to, double radius_m);

/// Returns the sum of the lengths of the pieces.
double Length(const std::vector<PathPiece>& pieces);

}  // namespace dn
