#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn::matching_internal {

/// The shift of a patch and its position.
struct PlacedShift {
  Eigen::Vector2d at_en_m = Eigen::Vector2d::Zero();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// The shifts that agree with their neighbours.
struct Agreement {
  std::vector<bool> agrees;
  /// Mean square of the normalised residuals that agree, at least 1: the covariances are too small
  /// by this factor.
  double variance_factor = 1.0;
  /// The same by direction: covariance of the normalised residuals, with eigenvalues of at least 1.
  Eigen::Matrix3d inflation = Eigen::Matrix3d::Identity();

  /// Returns the inflated covariance, C^(1/2) F C^(1/2) with the inflation F.
  Eigen::Matrix3d Inflated(const Eigen::Matrix3d& covariance_m2) const;
};

/// Finds the shifts that agree with their neighbours. A plane over all shifts is subtracted, then
/// each shift is compared with the median of its eight nearest neighbours, per axis. The residuals
/// are divided by their sigma, with that of the median, and by the robust scale of all residuals if
/// that exceeds 1. That scale accounts for the bending of the strips between neighbours. A shift
/// with more than 3.5 such units in any axis does not agree. Fewer than four shifts all agree.
///
/// The inflation has directions, because the scan lines of parallel strips lock onto each other.
/// Shifts along the track are then less accurate than those across it.
Agreement AgreeWithNeighbours(const std::vector<PlacedShift>& given);

/// The shift of a smooth patch along its normal, and its position.
struct PlacedHeight {
  Eigen::Vector2d at_en_m = Eigen::Vector2d::Zero();
  double shift_m = 0.0;
  double variance_m2 = 0.0;
};

/// The heights that agree with their neighbours.
struct HeightAgreement {
  std::vector<bool> agrees;
  double variance_factor = 1.0;  ///< as in Agreement
};

/// Does the same as AgreeWithNeighbours for heights.
HeightAgreement AgreeInHeight(const std::vector<PlacedHeight>& given);

}  // namespace dn::matching_internal
