#pragma once

#include <dn/factor.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/lidar_point_between_nodes.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/factors/prepared_pair.h>
#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// A laser return on a control point or plane, prepared for its factor.
struct PreparedControl {
  LidarEnd end;                                                ///< attached to its node
  Eigen::Matrix3d R_bs_nominal = Eigen::Matrix3d::Identity();  ///< mounting matrix sensor -> body
  Eigen::Vector3d z_m = Eigen::Vector3d::Zero();               ///< surveyed position, map
  /// Directions in which the true point may deviate from the surveyed one, one per column: three
  /// for a point, the normal for a plane.
  Eigen::Matrix<double, 3, Eigen::Dynamic> directions = Eigen::Matrix3d::Identity();
  /// Square root of the information of the return, one row per residual. A return that observes all
  /// coordinates has three rows. One that observes the distance from a surface has the row
  /// normal^T / sigma.
  Eigen::Matrix<double, Eigen::Dynamic, 3> sqrt_information = Eigen::Matrix3d::Identity();
  /// Whether the coordinates of the control have a common shift against those of the trajectory.
  bool with_datum_shift = false;
};

/// A laser return on a control point or plane.
///
///   r = W (x + s - z - E d)                                           [1 or 3], unitless
///
/// with the point x of LidarPointBetweenNodes, the surveyed position z, and the directions E. The
/// deviation d of the true point from the surveyed one is common to all returns of a control point.
/// The accuracy of the survey is a factor on d of its own; without it, the point is a check.
///
///   block | symbol      | stored | tangent | meaning
///   ------|-------------|--------|---------|-----------------------------------------------------
///     0   | q_mb        |   4    |    3    | rotation body -> map of the node before the epoch
///     1   | p_mb        |   3    |    3    | body origin in map of the node, m
///     2   | v_m         |   3    |    3    | velocity of the node with respect to the Earth, m/s
///     3   | q_boresight |   4    |    3    | Exp(theta), left of R_bs_nominal, about the body axes
///     4   | a_b         |   3    |    3    | lidar lever arm in body, m
///     5   | dt          |   1    |    1    | time offset of the lidar tags, s
///     6   | d           | 1 or 3 | 1 or 3  | deviation of the control point along E, m
///   then  | s           |   3    |    3    | datum shift from GNSS to control, map, m, if there is
///   then  | q_mb        |   4    |    3    | attitude of the node after the epoch, if bridged
///   then  | c, e, g     |   n    |    n    | effects as in PointToPointBetweenNodes
///
/// Jacobians are analytic, with the tangents of PointToPoint. Degenerate when: the factor is the
/// only one on d and has fewer residuals than d has elements.
class PointToControl final : public DynamicFactor {
 public:
  /// Throws InvalidInput as PointToPoint does, and for a position, direction or information that is
  /// not finite or does not fit.
  PointToControl(const LocalFrame& frame, const PreparedControl& control, LidarEffects lidar,
                 std::vector<GravitationBasis> attraction);

  bool Evaluate(double const* const* x, double* r, double** J) const override;

  /// Returns the georeferenced point in map, m, at the given blocks.
  Eigen::Vector3d Point(double const* const* x) const { return end_.At(blocks_, x).Position(); }

 private:
  PointToControl(const LocalFrame& frame, const PreparedControl& control, LidarPointBlocks blocks);

  LidarPointBlocks blocks_;
  LidarPointBetweenNodes end_;
  Eigen::Vector3d z_m_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> directions_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> W_;
  bool with_datum_shift_;
};

}  // namespace dn
