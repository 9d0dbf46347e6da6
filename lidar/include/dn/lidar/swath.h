#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

namespace dn {

/// What a strip covers, seen from above; east and north in the mapping frame m, m.
struct Swath {
  std::string strip;
  std::vector<Eigen::Vector2d> line_en_m;     ///< path of the body
  std::vector<Eigen::Vector2d> outline_en_m;  ///< polygon, its first corner not repeated
};

/// The outline of the points of a strip. Of each stretch of time it keeps the outermost points in 16
/// directions; of these the outline has those to the left and to the right of the course. Memory
/// grows with the duration, not with the points, whose order does not matter.
class SwathOutline {
 public:
  /// p_m: a point in the mapping frame, m.
  void Add(double t_s, const Eigen::Vector3d& p_m);

  /// At most 120 corners; none of fewer than three points.
  std::vector<Eigen::Vector2d> Corners() const;

 private:
  static constexpr std::size_t kDirections = 16;

  struct Stretch {
    double points = 0.0;
    Eigen::Vector2d sum_en_m = Eigen::Vector2d::Zero();
    std::array<Eigen::Vector2d, kDirections> outermost_en_m;

    void Add(const Eigen::Vector2d& p_en_m);
    void Join(const Stretch& other);
    Eigen::Vector2d Mean() const { return sum_en_m / points; }
    /// The outermost point in about the direction of a vector.
    const Eigen::Vector2d& Towards(const Eigen::Vector2d& direction_en) const;
  };

  static const std::array<Eigen::Vector2d, kDirections>& Directions();
  std::vector<Stretch> FewStretches() const;

  std::map<long, Stretch> by_second_;
};

/// `count` times from t0_s to t1_s, both included; count > 1.
std::vector<double> EvenTimes(double t0_s, double t1_s, std::size_t count);

}  // namespace dn
