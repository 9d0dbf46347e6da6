#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn::internal {

/// The shift of a patch, and where.
struct PlacedShift {
  Eigen::Vector2d at_en_m = Eigen::Vector2d::Zero();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Which shifts agree with their neighbours.
struct Agreement {
  std::vector<bool> agrees;
  /// Of what is left over, the robust variance by that of the covariances, at least 1: how much
  /// less the shifts are known than these say.
  double variance_factor = 1.0;
};

/// Which shifts are those of their neighbours: a plane over all of them is taken off, then each is
/// compared with the median of the eight nearest others, by axis. What is left over is scaled by its own sigma, and by the robust scale of all of
/// them where that exceeds 1 (the strips bend against each other between neighbours); more than 3.5
/// of these in any axis do not agree. Fewer than four shifts all agree.
Agreement AgreeWithNeighbours(const std::vector<PlacedShift>& given);

}  // namespace dn::internal
