#pragma once

#include <dn/factors/node_bridge.h>
#include <dn/imu/preintegration.h>
#include <dn/lidar/beam.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <memory>
#include <optional>

namespace dn {

/// One end of a point pair: the data that lead from the node before the lidar epoch to the point.
struct LidarEnd {
  double tag_s = 0.0;  ///< time tag in the pair file
  /// Increments from the node to the lidar epoch, corrected with the current biases.
  /// IdentityIncrement if the epoch is that of the node.
  Preintegrated partial;
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();  ///< laser vector in the sensor frame, m
  /// Nominal position of the node, where gravitation is evaluated.
  Eigen::Vector3d p_nominal_m = Eigen::Vector3d::Zero();
  /// Conditions the increments on the attitude of the node after the epoch; null: unconditioned.
  std::shared_ptr<const IncrementConditioning> bridge = {};
  int scanner = 0;     ///< index of the scanner, see LidarReading
  int beam = kNoBeam;  ///< beam of the scanner
};

/// A point pair prepared for its factor: both ends attached to their nodes.
struct PreparedPair {
  LidarEnd i, j;  ///< the partial increments end at the epochs under the assumed calibration
  Eigen::Matrix3d R_bs_nominal = Eigen::Matrix3d::Identity();  ///< mounting matrix sensor -> body
  double dt_nominal_s = 0.0;  ///< delay of the time tags used for the partial increments, s
  /// Noise of the difference of the two points, map axes: the noise of the pair and of its partial
  /// increments (EndNoise).
  Noise<3> noise_m;
  /// Mounting matrix of the scanner of end j if it is another one than that of end i. The factor
  /// then has the blocks of the mountings of both.
  std::optional<Eigen::Matrix3d> R_bs_nominal_j = {};
};

/// Returns the covariance (m^2, map axes) that the white noise of the partial increments adds to
/// the georeferenced point. It follows from rotation, position and their correlation in R_mb (dR
/// l_b + dp). With a bridge it is the covariance conditioned on the next node. R_mb is the attitude
/// of the node; l_b is lever arm plus laser vector in body at the lidar epoch, m. Add the result of
/// both ends to the covariance of the pair's difference.
Eigen::Matrix3d EndNoise(const LidarEnd& end, const Eigen::Matrix3d& R_mb,
                         const Eigen::Vector3d& l_b);

namespace factors_internal {

/// These functions throw InvalidInput, beginning with `what`. They do so for a laser vector that is
/// zero or not finite, and for a nominal position that is not finite. They also do so for a
/// mounting matrix that is not a rotation (1e-6).
void CheckEnd(const char* what, const LidarEnd& end);
void CheckMounting(const char* what, const Eigen::Matrix3d& R_bs);

/// Makes these checks for a pair.
void CheckPreparedPair(const PreparedPair& pair);

}  // namespace factors_internal

}  // namespace dn
