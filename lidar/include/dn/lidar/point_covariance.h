#pragma once

#include <dn/eigen_alignment.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>

namespace dn {

/// Errors of the quantities from which a georeferenced point is computed. They are independent of
/// each other.
struct PointErrors {
  Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();  ///< covariance of p_mb, in m axes
  /// Covariance of the rotation vector d about b, q Exp(d).
  Eigen::Matrix3d attitude_rad2 = Eigen::Matrix3d::Zero();
  /// Covariance of the left perturbation, about b.
  Eigen::Matrix3d boresight_rad2 = Eigen::Matrix3d::Zero();
  double sigma_range_m = 0.0;
  /// Sigma of the direction of the beam, about each of two axes perpendicular to the beam.
  double sigma_beam_rad = 0.0;
};

/// Returns the covariance of Georeference(pose, mounting, u_s) in m axes, m^2, to first order:
///
///   C = P + R_mb ([u_b + a_b]x A [u_b + a_b]x^T + [u_b]x B [u_b]x^T
///                 + s_r^2 e e^T + s_d^2 |u|^2 (I - e e^T)) R_mb^T,     e = u_b / |u_b|
///
/// with P, A, B of position, attitude, boresight, and s_r, s_d of range and direction. Errors of
/// lever arm, time tags, pose interpolation and angle of incidence are not included. u_s must not
/// be zero.
Eigen::Matrix3d PointCovariance(const MapPose& pose, const Mounting& mounting,
                                const Eigen::Vector3d& u_s, const PointErrors& errors);

}  // namespace dn
