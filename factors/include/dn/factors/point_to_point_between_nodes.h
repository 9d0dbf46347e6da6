#pragma once

#include <dn/factor.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/lidar_point_between_nodes.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/preintegrated_inertial.h>

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

namespace dn {

/// PointToPoint with each end between two nodes, and with calibration values of lidar, inertial
/// sensors and gravity among its blocks.
///
///   r = W (x_i - x_j)                                                         [3], unitless
///
/// The point x of each end is that of LidarPointBetweenNodes.
///
///   block  | symbol | stored | tangent | meaning
///   -------|--------|--------|---------|----------------------------------------------------------
///    0 - 8 |        |        |         | as in PointToPoint; 6 - 8 are of the scanner of end i
///    then  |        |        |         | the same three of the scanner of end j, if it is another
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
  PointToPointBetweenNodes(const LocalFrame& frame, const PreparedPair& pair,
                           LidarPointBlocks blocks);

  const LidarPointBetweenNodes& Point(PointPairFactor::End end) const {
    return end == PointPairFactor::End::kI ? i_ : j_;
  }

  /// Writes the Jacobians of W times the point of an end with respect to its mounting.
  void PutMounting(const LidarPointBetweenNodes& end, const LidarPointBetweenNodes::State& at,
                   const LidarPoint::Derivatives& of, const Eigen::Matrix3d& W,
                   double const* const* x, double** J) const;

  LidarPointBlocks blocks_;
  Eigen::Matrix3d W_;
  LidarPointBetweenNodes i_, j_;
};

}  // namespace dn
