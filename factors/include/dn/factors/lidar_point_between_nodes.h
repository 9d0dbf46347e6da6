#pragma once

#include <dn/block.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/lidar_point.h>
#include <dn/factors/node_bridge.h>
#include <dn/factors/point_sensitivity.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/factors/prepared_pair.h>
#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

namespace dn {

/// The blocks of a factor on lidar points that belong neither to a node nor to a scanner.
///
///   block             | symbol      | meaning
///   ------------------|-------------|-----------------------------------------------------
///   first_effect ...  | c, e, g     | effects of the lidar, of the increments, on gravitation, SI
struct LidarPointBlocks {
  std::size_t first_effect = 0;
  LidarEffects lidar;
  ImuEffectValues imu;  ///< values at the linearisation of the increments
  std::vector<GravitationBasis> attraction;

  std::size_t first_imu() const { return first_effect + lidar.size(); }
  std::size_t first_attraction() const { return first_imu() + imu.size(); }
  std::size_t num_effects() const { return lidar.size() + imu.size() + attraction.size(); }
  /// Returns the total size of the effect blocks.
  Eigen::Index NumEffectValues() const;
  /// Appends the kinds of the effect blocks.
  void AppendEffectKinds(std::vector<BlockKind>* kinds) const;
};

/// The blocks of the scanner of a lidar point.
///
///   block      | symbol      | meaning
///   -----------|-------------|-----------------------------------------------------
///   first      | q_boresight | Exp(theta), left of R_bs_nominal, about the body axes
///   first + 1  | a_b         | lidar lever arm in body, m
///   first + 2  | dt          | time offset of the lidar tags, s
struct MountingBlocks {
  std::size_t first = 0;
  Eigen::Matrix3d R_bs_nominal = Eigen::Matrix3d::Identity();
};

/// A LidarPoint with the corrections of all calibration values. If the end has a bridge, its
/// increments are conditioned on the node after it (IncrementConditioning).
///
/// The effects of the lidar correct the laser vector, the epoch (tag - dt - delay), and the
/// boresight Exp(theta + turn). The increments are corrected by the bridge, by the inertial effects
/// to first order, and by the additional gravitation.
class LidarPointBetweenNodes {
 public:
  LidarPointBetweenNodes() = default;
  /// `node` is the index of the first of the three blocks of the node (q_mb, p_mb, v_m). Only a
  /// bridge uses `node_after`, the index of the attitude of the node after the epoch.
  LidarPointBetweenNodes(const LocalFrame& frame, const LidarEnd& end,
                         const MountingBlocks& mounting, std::size_t node, std::size_t node_after);

  /// The point at given values of the blocks.
  struct State {
    LidarPoint point;
    LidarPoint::Arguments arguments;
    LidarReading reading;
    Eigen::Vector3d theta;  ///< rotation vector of its boresight
    Eigen::Vector3d turn;   ///< rotation correction of its increments
    IncrementConditioning::Correction bridged;

    Eigen::Vector3d Position() const;
    /// Returns the Jacobian of the point with respect to its increments.
    Eigen::Matrix<double, 3, 9> IncrementJacobian() const;
  };
  State At(const LidarPointBlocks& blocks, double const* const* x) const;

  bool has_bridge() const { return bridge_ != nullptr; }
  std::size_t node_after() const { return node_after_; }
  /// Returns the index of the first block of the mounting.
  std::size_t mounting() const { return mounting_.first; }

  /// Returns the Jacobians of W times the point; `of` are the derivatives of at.point.
  PointSensitivity Sensitivity(const State& at, const LidarPoint::Derivatives& of,
                               const Eigen::Matrix3d& W) const;

  /// Adds the Jacobian with respect to the values of all effects; `point` is from Sensitivity.
  void AddEffects(const LidarPointBlocks& blocks, const State& at, const PointSensitivity& point,
                  Eigen::Matrix3Xd* sum) const;

 private:
  LidarPoint point_;
  double tag_s_ = 0.0, t_end_s_ = 0.0;
  Eigen::Vector3d u_s_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 9, Eigen::Dynamic> J_increments_;
  std::shared_ptr<const IncrementConditioning> bridge_;
  MountingBlocks mounting_;
  std::size_t node_ = 0, node_after_ = 0;
  int scanner_ = 0;
  int beam_ = kNoBeam;
};

namespace factors_internal {

/// Returns d theta' / d theta of the left tangents. The Jacobian with respect to the turned
/// boresight Exp(theta) times this matrix is the one with respect to the block q_boresight.
Eigen::Matrix3d FromBoresightBlock(const Eigen::Vector3d& theta, const double* q_boresight);

}  // namespace factors_internal

}  // namespace dn
