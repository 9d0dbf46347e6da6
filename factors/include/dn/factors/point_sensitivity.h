#pragma once

#include <dn/factors/lidar_effect.h>
#include <dn/factors/lidar_point.h>
#include <dn/factors/preintegrated_inertial.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Jacobians of the whitened residual of a pair with respect to changes of the data of one point.
/// The columns of any effect, whether the factor has it or not, follow from them
/// (AddEffectJacobians).
struct PointSensitivity {
  Eigen::Matrix3d u_b;        ///< laser vector R_bs_nominal u_s, m
  Eigen::Matrix3d turn_b;     ///< rotation added to the rotation vector of the boresight, rad
  Eigen::Matrix3d lever_arm;  ///< m
  Eigen::Vector3d delay;      ///< delay of the time tag, s
  /// Increments to the epoch, tangent order of Preintegrated.
  Eigen::Matrix<double, 3, 9> increments;
  /// Rotation increment of the whole interval to the next node, rad; zero if the end has no
  /// IncrementConditioning.
  Eigen::Matrix3d whole = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d attraction;  ///< gravitation in addition to the normal one, map axes, m/s^2
};

/// Returns the Jacobians of W x for the point x of a LidarPoint at the given arguments. theta_rad
/// is the rotation vector of the boresight at.q_boresight; `of` are the derivatives of the point
/// there.
PointSensitivity ComputePointSensitivity(const LidarPoint& point, const LidarPoint::Arguments& at,
                                         const LidarPoint::Derivatives& of,
                                         const Eigen::Vector3d& theta_rad,
                                         const Eigen::Matrix3d& W);

/// Derivatives of the data of a point with respect to the values of effects, one column per
/// component.
struct EffectsOnPoint {
  const LidarReading& reading;  ///< reading with its derivatives with respect to the lidar effects
  /// Derivatives of the increments to the epoch with respect to the inertial effects.
  const Eigen::Matrix<double, 9, Eigen::Dynamic>& increments;
  /// Derivatives of the rotation increment of the whole interval with respect to the same effects;
  /// null without a bridge.
  const Eigen::Matrix3Xd* whole = nullptr;
  const std::vector<GravitationBasis>& attraction;
};

/// Adds d residual / d value to `sum`. Its columns are those of the lidar effects, then of the
/// inertial effects, then of the effects on gravitation. R_bs_nominal is the mounting matrix.
void AddEffectJacobians(const PointSensitivity& point, const EffectsOnPoint& effects,
                        const Eigen::Matrix3d& R_bs_nominal, Eigen::Ref<Eigen::Matrix3Xd> sum);

}  // namespace dn
