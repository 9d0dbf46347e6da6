#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

namespace dn {

/// Area that a strip covers in plan view, in the mapping frame m, in metres.
struct Swath {
  std::string strip;
  std::vector<Eigen::Vector3d> line_m;  ///< path of the body
  /// Polygon, east and north; the first corner is not repeated at the end.
  std::vector<Eigen::Vector2d> outline_en_m;
  double outline_up_m = 0.0;  ///< mean height of the ground
};

/// Computes the outline of the points of a strip. For each second of time it keeps the outermost
/// points in 16 directions. The outline connects those to the left and to the right of the course.
/// Memory grows with the duration, not with the number of points; the order of the points does not
/// matter.
class SwathOutline {
 public:
  /// Adds a point p_m in the mapping frame, m.
  void Add(double t_s, const Eigen::Vector3d& p_m);

  /// Returns at most 120 corners; empty for fewer than three points.
  std::vector<Eigen::Vector2d> Corners() const;

  /// Returns the mean height of the points, m; 0 without points.
  double MeanUp() const { return points_ == 0.0 ? 0.0 : sum_up_m_ / points_; }

 private:
  static constexpr std::size_t kDirections = 16;

  /// Points of one second, or of several joined seconds.
  struct Stretch {
    double points = 0.0;
    Eigen::Vector2d sum_en_m = Eigen::Vector2d::Zero();
    std::array<Eigen::Vector2d, kDirections> outermost_en_m;

    void Add(const Eigen::Vector2d& p_en_m);
    void Join(const Stretch& other);
    Eigen::Vector2d Mean() const { return sum_en_m / points; }
    /// Returns the outermost point in the direction closest to `direction_en`.
    const Eigen::Vector2d& Towards(const Eigen::Vector2d& direction_en) const;
  };

  /// Returns unit vectors in 16 equally spaced directions.
  static const std::array<Eigen::Vector2d, kDirections>& Directions();
  /// Joins neighbouring stretches so that at most 60 remain.
  std::vector<Stretch> FewStretches() const;

  std::map<long, Stretch> by_second_;
  double points_ = 0.0, sum_up_m_ = 0.0;
};

/// Returns `count` equally spaced times from t0_s to t1_s, both included; `count` must exceed 1.
std::vector<double> EvenTimes(double t0_s, double t1_s, std::size_t count);

}  // namespace dn
