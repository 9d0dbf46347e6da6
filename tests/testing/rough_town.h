#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "roofs.h"

namespace dn::testing {

/// A town of houses at many angles on hilly ground, with a known height everywhere.
class RoughTown {
 public:
  explicit RoughTown(bool flat = false) : flat_(flat) {
    for (int i = 0; i < 6 && !flat; ++i) {
      for (int k = 0; k < 6; ++k) {
        roofs_.push_back({{25.0 * i + 3.0 * std::sin(7.0 * k), 25.0 * k + 3.0 * std::cos(5.0 * i)},
                          14.0,
                          5.0,
                          0.6,
                          5.0,
                          0.7 * i + 1.1 * k});
      }
    }
  }

  double Height(const Eigen::Vector2d& en_m) const {
    if (flat_) return 0.0;
    return SurfaceHeight(roofs_, en_m) + 2.0 * std::sin(0.11 * en_m.x() + 0.05 * en_m.y()) +
           1.5 * std::sin(0.13 * en_m.y()) + 0.3 * std::sin(0.9 * en_m.x() - 0.7 * en_m.y());
  }

  /// Returns points at random places of the square up to edge_m, shifted by shift_m.
  std::vector<Eigen::Vector3d> Points(int count, double edge_m, double sigma_m,
                                      const Eigen::Vector3d& shift_m, unsigned seed) const {
    std::mt19937_64 engine(seed);
    std::uniform_real_distribution<double> place(0.0, edge_m);
    std::normal_distribution<double> noise(0.0, sigma_m);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < count; ++i) {
      // Separate statements, because the order of evaluation of arguments is unspecified.
      const double north_m = place(engine);
      const double east_m = place(engine);
      const Eigen::Vector2d en_m(east_m, north_m);
      points.emplace_back(Eigen::Vector3d(en_m.x(), en_m.y(), Height(en_m) + noise(engine)) +
                          shift_m);
    }
    return points;
  }

 private:
  bool flat_;
  std::vector<Roof> roofs_;
};

}  // namespace dn::testing
