#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// Mounting of the scanner s on the body b: u_b = Exp([theta]x) R_bs_nominal u_s, a vector from the
/// scanner origin.
struct Mounting {
  Eigen::Matrix3d R_bs_nominal = Eigen::Matrix3d::Identity();  ///< scanner to body
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();     ///< scanner origin in body
  /// theta, rotation vector about the body axes.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
};

/// Returns the rotation nearest to R. Throws InvalidInput unless R is a rotation to within 1e-6
/// (orthonormal, determinant +1).
Eigen::Matrix3d CheckedRotation(const Eigen::Matrix3d& R);

/// Returns the laser vector in body: Exp([theta]x) R_bs_nominal u_s, m.
Eigen::Vector3d LaserVectorInBody(const Mounting& mounting, const Eigen::Vector3d& u_s);

/// Returns the laser vector in the sensor frame, R_bs_nominal^T Exp(-[theta]x) u_b, m: the inverse
/// of LaserVectorInBody.
Eigen::Vector3d LaserVectorInSensor(const Mounting& mounting, const Eigen::Vector3d& u_b);

/// Georeferences a laser vector directly: p_m = p_mb + R_mb (u_b + a_b), m (paper eq. 1).
Eigen::Vector3d Georeference(const MapPose& pose, const Mounting& mounting,
                             const Eigen::Vector3d& u_s);

/// Returns the laser vector in the sensor frame that leads to the point p_m, m: the inverse of
/// Georeference.
Eigen::Vector3d LaserVectorTo(const MapPose& pose, const Mounting& mounting,
                              const Eigen::Vector3d& p_m);

}  // namespace dn
