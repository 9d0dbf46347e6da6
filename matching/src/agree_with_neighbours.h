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

/// Which shifts are those of their neighbours: each is compared with the median of the eight nearest
/// others, by axis. What is left over is scaled by its own sigma, and by the robust scale of all of
/// them where that exceeds 1 (the strips bend against each other between neighbours); more than 3.5
/// of these in any axis do not agree. Fewer than four shifts all agree.
std::vector<bool> AgreeWithNeighbours(const std::vector<PlacedShift>& shifts);

}  // namespace dn::internal
