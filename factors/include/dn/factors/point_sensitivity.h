#pragma once

#include <dn/factors/lidar_effect.h>
#include <dn/factors/lidar_point.h>
#include <dn/factors/preintegrated_inertial.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// How far the whitened residual of a pair moves with what effects do to one of its points: the
/// columns of any effect, of the factor or not, follow from it (AddByEffects).
struct PointSensitivity {
  Eigen::Matrix3d u_b;        ///< laser vector T_bs u_s, m
  Eigen::Matrix3d turn_b;     ///< what is added to the rotation vector of the boresight, rad
  Eigen::Matrix3d lever_arm;  ///< m
  Eigen::Vector3d delay;      ///< of the time tag, s
  Eigen::Matrix<double, 3, 9> increments;  ///< to the epoch, tangent order of Preintegrated
  /// Rotation increment of the whole interval to the next node, where a NodeBridge has the end; rad.
  Eigen::Matrix3d whole = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d attraction;  ///< beyond the normal one, map axes, m/s^2
};

/// Of a LidarPoint at given arguments, by W times the point in map. theta_rad: rotation vector of
/// the boresight at.q_boresight; `of`: the point's derivatives there.
PointSensitivity SensitivityOf(const LidarPoint& point, const LidarPoint::Arguments& at,
                               const LidarPoint::Derivatives& of, const Eigen::Vector3d& theta_rad,
                               const Eigen::Matrix3d& W);

/// What the values of effects do to a point, a column for each component.
struct EffectsOnPoint {
  const LidarReading& reading;  ///< with the derivatives by the lidar's effects
  /// Of the increments to the epoch by the inertial effects.
  const Eigen::Matrix<double, 9, Eigen::Dynamic>& increments;
  /// Of the rotation increment of the whole interval by the same; null: there is no bridge.
  const Eigen::Matrix3Xd* whole = nullptr;
  const std::vector<AttractionBasis>& attraction;
};

/// Adds d residual / d value to `sum`: columns of the lidar's effects, the inertial ones, those on
/// the attraction. T_bs: nominal mounting.
void AddByEffects(const PointSensitivity& point, const EffectsOnPoint& effects,
                  const Eigen::Matrix3d& T_bs, Eigen::Ref<Eigen::Matrix3Xd> sum);

}  // namespace dn
