#pragma once

#include <dn/factor.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace dn {

/// PointToPoint with calibration values of lidar, inertial sensors and gravity among its blocks.
///
///   r = W (x_i - x_j)                                                         [3], unitless
///
/// The LidarPoint x of each end is that of the corrected reading: its laser vector, its epoch tag -
/// dt - delay, and the boresight Exp(theta + turn). The partial increments move with the values of
/// the inertial effects (to first order, d_e from their linearisation) and with the attraction.
///
///   block  | symbol | stored | tangent | meaning
///   -------|--------|--------|---------|----------------------------------------------------------
///    0 - 8 |        |        |         | as in PointToPoint
///    then  | c      |   n    |    n    | one per effect of the lidar, SI
///    then  | e      |   n    |    n    | one per inertial effect of the partial increments, SI
///    last  | g      |   n    |    n    | one per effect on the attraction, SI
///
/// Jacobians are analytic, with the tangents of PointToPoint.
class PointToPointWithEffects final : public DynamicFactor, public PointPairFactor {
 public:
  /// tags: of the file; the partial increments may end up to some ms beside tag - dt - delay. Both
  /// must have the same inertial effects. Throws InvalidInput as PointToPoint.
  PointToPointWithEffects(const LocalFrame& frame, const LidarEnd& i, const LidarEnd& j,
                          double tag_i_s, double tag_j_s, const Eigen::Matrix3d& T_bs_nominal,
                          LidarEffects lidar, std::vector<AttractionBasis> attraction,
                          const Noise<3>& noise_m);

  bool Evaluate(double const* const* x, double* r, double** J) const override;

  std::pair<Eigen::Vector3d, Eigen::Vector3d> Points(double const* const* x) const override;

 private:
  struct End {
    LidarPoint point;
    double tag_s, t_end_s;
    Eigen::Vector3d u_s;
    Eigen::Matrix<double, 9, Eigen::Dynamic> J_increments;
  };
  /// An end at given values of the blocks.
  struct EndAt {
    LidarPoint point;
    LidarPoint::Arguments arguments;
    LidarReading reading;
    Eigen::Vector3d theta;  // rotation vector of its boresight
    Eigen::Vector3d turn;   // of its increments, by the inertial effects
  };

  static End MakeEnd(const LocalFrame& frame, const LidarEnd& end, double tag_s);
  EndAt At(const End& end, double const* const* node, double const* const* x) const;
  Eigen::VectorXd ImuChange(double const* const* x) const;
  Eigen::Vector3d AttractionOf(double const* const* x) const;

  /// Of an end's point with respect to the values of all effects, in the order of the blocks.
  Eigen::Matrix3Xd ByEffects(const End& end, const EndAt& at,
                             const LidarPoint::Derivatives& of) const;

  int first_imu_block() const { return 9 + static_cast<int>(lidar_.size()); }
  int first_attraction_block() const {
    return first_imu_block() + static_cast<int>(imu_values_.size());
  }

  LidarEffects lidar_;
  std::vector<Eigen::VectorXd> imu_values_;  // of the linearisation
  std::vector<AttractionBasis> attraction_;
  Eigen::Matrix3d T_bs_;
  Eigen::Matrix3d W_;
  End i_, j_;
};

}  // namespace dn
