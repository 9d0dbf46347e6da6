#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace dn::testing {

/// A house with a gable roof; the ridge is along its own y axis.
struct Roof {
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();
  double length_m = 10.0;     ///< along the ridge
  double half_width_m = 6.0;  ///< of each side, in plan view
  double slope_rad = 0.6;
  double eaves_m = 6.0;   ///< above the ground
  double turn_rad = 0.0;  ///< of the ridge from north towards west
};

/// Returns the height of the surface: ground at zero, with the roofs on it.
inline double SurfaceHeight(const std::vector<Roof>& roofs, const Eigen::Vector2d& en_m) {
  double height_m = 0.0;
  for (const Roof& roof : roofs) {
    const Eigen::Vector2d d = en_m - roof.centre_en_m;
    const double c = std::cos(roof.turn_rad), s = std::sin(roof.turn_rad);
    const double across_m = std::abs(c * d.x() + s * d.y());
    const double along_m = std::abs(-s * d.x() + c * d.y());
    if (across_m > roof.half_width_m || along_m > 0.5 * roof.length_m) continue;
    height_m = std::max(height_m,
                        roof.eaves_m + (roof.half_width_m - across_m) * std::tan(roof.slope_rad));
  }
  return height_m;
}

}  // namespace dn::testing
