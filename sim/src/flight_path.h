#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Where and which way: east, north (m) and heading (rad, clockwise from north).
struct Waypoint {
  Eigen::Vector2d en_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
};

/// A straight line (curvature 0) or a circular arc; curvature is positive to the right.
struct PathPiece {
  double length_m = 0.0;
  double curvature_per_m = 0.0;
};

/// The waypoint after `length_m` along a piece of the given curvature; the heading is continued,
/// not wrapped.
Waypoint Advance(const Waypoint& from, double length_m, double curvature_per_m);

/// Shortest path of arcs of radius_m and straight lines from one waypoint to another (Dubins,
/// 1957): arc-line-arc, or three arcs. Its last waypoint has the heading of `to` up to whole turns.
std::vector<PathPiece> ShortestPath(const Waypoint& from, const Waypoint& to, double radius_m);

/// Sum of the pieces' lengths.
double Length(const std::vector<PathPiece>& pieces);

}  // namespace dn
