#pragma once

#include <dn/sim/random.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace dn {

/// Random numbers in [0, 1) that depend only on the cell of a grid.
class CellNumbers {
 public:
  CellNumbers(std::uint64_t seed, const Eigen::Vector2i& cell) {
    const auto x = static_cast<std::uint32_t>(cell.x());
    const auto y = static_cast<std::uint32_t>(cell.y());
    state_ = MixBits(seed ^ MixBits((static_cast<std::uint64_t>(x) << 32) | y));
  }
  double Next() {
    state_ = MixBits(state_);
    return static_cast<double>(state_ >> 11) * 0x1.0p-53;
  }
  double Next(double low, double high) { return low + (high - low) * Next(); }

 private:
  std::uint64_t state_;
};

/// Returns the grid cell that contains a point.
inline Eigen::Vector2i CellAt(const Eigen::Vector2d& en_m, double cell_m) {
  return {static_cast<int>(std::floor(en_m.x() / cell_m)),
          static_cast<int>(std::floor(en_m.y() / cell_m))};
}

/// Rectangular house in its cell, with a flat, gabled or single-pitched roof.
struct Building {
  Eigen::Vector2d centre_en_m;
  Eigen::Vector2d axis;  // unit vector along the length
  double half_length_m;
  double half_width_m;
  double eaves_m;  // above the ground at the centre
  double slope;    // slope of the roof, 0: flat
  bool gabled;

  Building(CellNumbers numbers, const Eigen::Vector2i& cell, double cell_m, double margin_m) {
    const double room_m = 0.5 * cell_m - margin_m;  // radius of a circle that contains the house
    const double radius_m = std::min(room_m, numbers.Next(7.0, 16.0));
    const double aspect = numbers.Next(0.45, 1.0);
    half_length_m = radius_m / std::hypot(1.0, aspect);
    half_width_m = aspect * half_length_m;
    const double play_m = room_m - radius_m;
    const double dx = numbers.Next(-play_m, play_m), dy = numbers.Next(-play_m, play_m);
    centre_en_m =
        (cell.cast<double>() + Eigen::Vector2d::Constant(0.5)) * cell_m + Eigen::Vector2d(dx, dy);
    const double azimuth = numbers.Next(0.0, std::numbers::pi);
    axis = {std::cos(azimuth), std::sin(azimuth)};
    eaves_m = numbers.Next(3.0, 12.0);
    const double roof = numbers.Next();
    gabled = roof >= 0.3 && roof < 0.85;
    slope = roof < 0.3
                ? 0.0
                : std::tan(numbers.Next(15.0, gabled ? 40.0 : 25.0) * std::numbers::pi / 180.0);
  }

  /// Converts a point to the axes of the house: along its length and across, from the centre.
  Eigen::Vector2d ToAxes(const Eigen::Vector2d& en_m) const {
    const Eigen::Vector2d d = en_m - centre_en_m;
    return {d.dot(axis), axis.x() * d.y() - axis.y() * d.x()};
  }

  /// Returns the roof height above the ground at the centre, at a distance across the house.
  double RoofAcross(double across_m) const {
    const double rise =
        gabled ? half_width_m - std::abs(across_m) : 0.5 * (half_width_m + across_m);
    return eaves_m + slope * rise;
  }

  /// Returns the roof height above the ground at the centre; negative outside the house.
  double Above(const Eigen::Vector2d& en_m) const {
    const Eigen::Vector2d at = ToAxes(en_m);
    if (std::abs(at.x()) > half_length_m || std::abs(at.y()) > half_width_m) return -1.0;
    return RoofAcross(at.y());
  }

  double radius_m() const { return std::hypot(half_length_m, half_width_m); }
  double highest_m() const { return eaves_m + slope * half_width_m; }
};

/// Tree in its cell: a paraboloid that ends above the ground.
struct Tree {
  static constexpr double kDroop = 0.6;  // fraction of the height between top and edge of the crown

  Eigen::Vector2d centre_en_m;
  double radius_m;
  double height_m;

  Tree(CellNumbers numbers, const Eigen::Vector2i& cell, double cell_m) {
    radius_m = std::min(0.5 * cell_m, numbers.Next(1.5, 4.0));
    const double play_m = 0.5 * cell_m - radius_m;
    const double dx = numbers.Next(-play_m, play_m), dy = numbers.Next(-play_m, play_m);
    centre_en_m =
        (cell.cast<double>() + Eigen::Vector2d::Constant(0.5)) * cell_m + Eigen::Vector2d(dx, dy);
    height_m = numbers.Next(5.0, 18.0);
  }

  /// Returns the crown height above the ground at the centre; negative outside the crown.
  double Above(const Eigen::Vector2d& en_m) const {
    const double x = (en_m - centre_en_m).squaredNorm() / (radius_m * radius_m);
    return x > 1.0 ? -1.0 : height_m * (1.0 - kDroop * x);
  }
};

}  // namespace dn
