#pragma once

#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// How the scanner s sits on the body b: u_b = Exp([theta]x) T_s^b* u_s, seen from the lever arm.
struct Mounting {
  Eigen::Matrix3d R_bs_nominal = Eigen::Matrix3d::Identity();  ///< T_s^b*, sensor -> nominal body
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();     ///< scanner origin in body
  Eigen::Vector3d boresight_rad =
      Eigen::Vector3d::Zero();  ///< theta, rotation vector about the body axes
};

/// Throws InvalidInput unless R is a rotation to 1e-6 (orthonormal, determinant +1); returns the
/// nearest one.
Eigen::Matrix3d CheckedRotation(const Eigen::Matrix3d& R);

/// Laser vector in body: Exp([theta]x) T_s^b* u_s, m.
Eigen::Vector3d LaserVectorInBody(const Mounting& mounting, const Eigen::Vector3d& u_s);

/// Its inverse: the laser vector in the sensor frame, T_s^b*^T Exp(-[boresight]x) u_b, m.
Eigen::Vector3d LaserVectorInSensor(const Mounting& mounting, const Eigen::Vector3d& u_b);

/// Direct georeferencing: p_m = p_mb + R_mb (u_b + a_b), m. (Paper eq. 1.)
Eigen::Vector3d Georeference(const MapPose& pose, const Mounting& mounting,
                             const Eigen::Vector3d& u_s);

/// Its inverse: the laser vector in the sensor frame that led to the point p_m, m.
Eigen::Vector3d LaserVectorTo(const MapPose& pose, const Mounting& mounting,
                              const Eigen::Vector3d& p_m);

}  // namespace dn
