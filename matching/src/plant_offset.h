#pragma once

#include <dn/fixed_trajectory/gauss_helmert.h>

#include <Eigen/Core>
#include <vector>

namespace dn::matching_internal {

/// A pair of a flight for the estimation of the range offset of plants.
struct PlantPair {
  GaussHelmertPair pair;
  std::size_t strip_i = 0, strip_j = 0;
  Eigen::Matrix3d volumetric_share = Eigen::Matrix3d::Zero();  ///< see Registration
  Eigen::Vector3d beam_i = Eigen::Vector3d::Zero();  ///< unit vector of the beam, map axes
  Eigen::Vector3d beam_j = Eigen::Vector3d::Zero();

  /// Returns p_i - p_j per metre of offset.
  Eigen::Vector3d Effect() const { return volumetric_share * (beam_i - beam_j); }
};

struct PlantOptions {
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  double boresight_sigma_rad = 0.1;
  /// Sigmas of the errors of position and attitude that are constant in a strip.
  double strip_position_sigma_m = 0.05;
  double strip_attitude_sigma_rad = 1e-4;
  double offset_sigma_m = 0.0;  ///< prior of the offset, about zero
  std::size_t strips = 0;
};

struct PlantOffset {
  double offset_m = 0.0;
  double sigma_m = 0.0;
};

/// Estimates the apparent range offset of plants, kappa. Two strips see a plant from different
/// sides. Their returns differ as if ranges to plants had the offset kappa:
///
///   p_i - p_j = A d + B_i c_i + B_j c_j + kappa S (e_i - e_j) + noise
///
/// with the boresight d, the trajectory errors c of each strip, the volumetric share S of the cell
/// and the unit vectors e of the beams. In the overlap of crossing strips, the effect of the offset
/// depends on the place, and that of a constant boresight error does not. Without such strips the
/// prior bounds the offset.
///
/// The sigma includes a fifth of the offset: the offset differs that much between strip pairs.
PlantOffset EstimatePlantOffset(const std::vector<PlantPair>& pairs, const PlantOptions& options);

}  // namespace dn::matching_internal
