#pragma once

#include <dn/factor.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/node_bridge.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/preintegrated_inertial.h>

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace dn {

/// PointToPoint with each end between two nodes, and with calibration values of lidar, inertial
/// sensors and gravity among its blocks.
///
///   r = W (x_i - x_j)                                                         [3], unitless
///
/// The LidarPoint x of each end uses the corrected reading: its laser vector, its epoch tag - dt -
/// delay, and the boresight Exp(theta + turn). The partial increments are corrected by the
/// IncrementConditioning and by the additional gravitation. They are also corrected by the values
/// of the inertial effects, to first order (d_e from their linearisation).
///
///   block  | symbol | stored | tangent | meaning
///   -------|--------|--------|---------|----------------------------------------------------------
///    0 - 8 |        |        |         | as in PointToPoint
///    then  | q_mb   |   4    |    3    | attitude of the node after i, if i has a bridge
///    then  | q_mb   |   4    |    3    | attitude of the node after j, if j has a bridge
///    then  | c      |   n    |    n    | one per effect of the lidar, SI
///    then  | e      |   n    |    n    | one per inertial effect of the partial increments, SI
///    last  | g      |   n    |    n    | one per effect on gravitation, SI
///
/// Jacobians are analytic, with the tangents of PointToPoint.
class PointToPointBetweenNodes final : public DynamicFactor, public PointPairFactor {
 public:
  /// The partial increments may end some ms before or after tag - dt - delay. Both ends must have
  /// the same inertial effects. Throws InvalidInput as PointToPoint does.
  PointToPointBetweenNodes(const LocalFrame& frame, const PreparedPair& pair, LidarEffects lidar,
                           std::vector<GravitationBasis> attraction);

  bool Evaluate(double const* const* x, double* r, double** J) const override;

  std::pair<Eigen::Vector3d, Eigen::Vector3d> Points(double const* const* x) const override;
  std::optional<PointSensitivity> SensitivityAt(PointPairFactor::End end,
                                                double const* const* x) const override;

 private:
  struct End {
    LidarPoint point;
    double tag_s, t_end_s;
    Eigen::Vector3d u_s;
    Eigen::Matrix<double, 9, Eigen::Dynamic> J_increments;
    std::shared_ptr<const IncrementConditioning> bridge;
    std::size_t node, node_after;  // indices of the first blocks
  };
  /// An end at given values of the blocks.
  struct EndAt {
    LidarPoint point;
    LidarPoint::Arguments arguments;
    LidarReading reading;
    Eigen::Vector3d theta;  // rotation vector of its boresight
    Eigen::Vector3d turn;   // rotation correction of its increments by bridge and inertial effects
    IncrementConditioning::Correction bridged;
  };

  static End MakeEnd(const LocalFrame& frame, const LidarEnd& end, std::size_t node,
                     std::size_t node_after);
  EndAt At(const End& end, double const* const* x) const;
  Eigen::Index NumEffectValues() const;
  Eigen::VectorXd ImuChange(double const* const* x) const;
  Eigen::Vector3d AdditionalGravitation(double const* const* x) const;

  /// Returns the Jacobian of an end's point with respect to its increments.
  static Eigen::Matrix<double, 3, 9> IncrementJacobian(const EndAt& at);
  static PointSensitivity EndSensitivity(const End& end, const EndAt& at,
                                         const LidarPoint::Derivatives& of,
                                         const Eigen::Matrix3d& W);
  void AddEndEffectJacobians(const End& end, const EndAt& at, const PointSensitivity& point,
                             Eigen::Matrix3Xd* sum) const;

  std::size_t first_imu_block() const { return first_lidar_block_ + lidar_.size(); }
  std::size_t first_attraction_block() const { return first_imu_block() + imu_.size(); }

  std::size_t first_lidar_block_;
  LidarEffects lidar_;
  ImuEffectValues imu_;  // values at the linearisation
  std::vector<GravitationBasis> attraction_;
  Eigen::Matrix3d R_bs_nominal_;
  Eigen::Matrix3d W_;
  End i_, j_;
};

}  // namespace dn
