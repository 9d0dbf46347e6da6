#pragma once

#include <Eigen/Core>
#include <vector>

#include "agree_with_neighbours.h"

namespace dn::matching_internal {

/// A plane over east and north for each axis of the shifts between two strips.
struct ShiftTrend {
  Eigen::Vector2d centre_en_m = Eigen::Vector2d::Zero();
  /// One row per axis: value at the centre, slopes to the east and to the north.
  Eigen::Matrix3d coefficients = Eigen::Matrix3d::Zero();

  Eigen::Vector3d At(const Eigen::Vector2d& en_m) const {
    const Eigen::Vector2d off_m = en_m - centre_en_m;
    return coefficients * Eigen::Vector3d(1.0, off_m.x(), off_m.y());
  }
};

/// Fits the planes with Huber's weights. Fewer than eight shifts give their weighted mean; at least
/// one is needed.
ShiftTrend FitTrend(const std::vector<PlacedShift>& shifts);

/// Returns the root mean square of the shifts about their trend, per axis, with the degrees of
/// freedom of the trend. At least four shifts are needed.
Eigen::Vector3d ScatterAbout(const ShiftTrend& trend, const std::vector<PlacedShift>& shifts);

}  // namespace dn::matching_internal
