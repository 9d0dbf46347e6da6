#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>

namespace dn {

/// Effect of the Earth's rotation over one interval, for the rotating-Earth form of the inertial
/// factor.
///
/// The map frame m rotates with the constant rate w = w_ie_m. The inertial axes coincide with m at
/// the beginning t_i of the interval. rho = r0 + p is the position from the centre of the Earth in
/// m axes. The motion to t_j = t_i + dt is
///
///   R_i dR = C R_j
///   R_i dv = C (v_j + w x rho_j) - (v_i + w x rho_i)                   - dt/2 (G_i + C G_j)
///   R_i dp = C rho_j - rho_i - (v_i + w x rho_i) dt                 - dt^2 (G_i/3 + C G_j/6)
///
/// with C = Exp(w dt), G the gravitation at both ends (taken linear in time), and dR, dv, dp the
/// increments of Preintegrate. This struct contains the parts of the right-hand sides that do not
/// depend on p and v. They are evaluated without cancellation of terms of the size of r0 (6.4e6 m):
///
///   C rho_j - rho_i - (w x rho_i) dt = C p_j - p_i - (w x p_i) dt + origin_position_m
///   C (w x rho_j) - w x rho_i        = C (w x p_j) - w x p_i      + origin_velocity_mps
///
/// Accuracy: 1e-15 relative. Gravitation that is linear in time leaves two errors. At dt = 1 s they
/// are g (w dt)^2 / 12 = 4e-9 m/s^2, and Gamma a dt^2 / 12 = 3e-7 m/s^2 per m/s^2 of acceleration
/// a. Source: Brossard et al. 2021 (auxiliary velocity v + w x rho).
struct EarthStep {
  double dt_s = 0.0;
  /// Rotation from m axes at the end to m axes at the beginning.
  Eigen::Matrix3d C = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_position_m = Eigen::Vector3d::Zero();    ///< (C - I) r0 - (w x r0) dt
  Eigen::Vector3d origin_velocity_mps = Eigen::Vector3d::Zero();  ///< (C - I) (w x r0)

  /// Computes the step for an interval dt_s of either sign.
  static EarthStep Make(const LocalFrame& frame, double dt_s);
};

/// Returns the derivative of gravitation with respect to position at p_m, 1/s^2, by central
/// differences (relative accuracy 1e-7).
Eigen::Matrix3d GravitationGradient(const LocalFrame& frame, const Eigen::Vector3d& p_m);

/// Computes pose and velocity at the end of increments that begin at `start`, from the equations of
/// EarthStep. The gravitation at the end is that of a position predicted with the gravitation at
/// the beginning. The error of this one iteration is below 1e-6 m after 1 s at 100 m/s. start.t_s
/// is not compared with the beginning of the increments; the result has the time of their end.
/// added_mps2: gravitation in addition to the normal one, map axes.
class Propagation {
 public:
  /// `frame` must outlive this object.
  Propagation(const LocalFrame& frame, const MapPose& start,
              const Eigen::Vector3d& added_mps2 = Eigen::Vector3d::Zero());

  /// Returns pose and velocity at the end of the increments.
  MapPose To(const InertialIncrements& increments) const;

 private:
  const LocalFrame& frame_;
  MapPose start_;
  Eigen::Vector3d added_mps2_;
  Eigen::Vector3d G_begin_;
};

/// Propagates `start` to a single end, as Propagation does.
MapPose Propagate(const LocalFrame& frame, const MapPose& start,
                  const InertialIncrements& increments,
                  const Eigen::Vector3d& added_mps2 = Eigen::Vector3d::Zero());

/// Propagate as an affine function of position and velocity at the beginning. Gravitation is
/// linearised at p_nominal_m:
///
///   p' = p_p p + p_v v + p_d R dp + p_0
///   v' = v_p p + v_v v + C^T R dv + v_d R dp + v_0
///   R' = C^T R dR
///
/// where R = R_mb at the beginning and dR, dv, dp are the increments. The result equals that of
/// Propagate within 1e-6 m/s^2 x dt^2 / 2 for |p - p_nominal| < 1 km and dt <= 1 s (curvature of
/// the gravitation).
struct AffineStep {
  Eigen::Matrix3d p_p, p_v, p_d;
  Eigen::Vector3d p_0;
  Eigen::Matrix3d v_p, v_v, v_d;
  Eigen::Vector3d v_0;
  Eigen::Matrix3d C;  ///< as in EarthStep

  /// Computes the coefficients for an interval dt_s. Gravitation is linearised at p_nominal_m.
  static AffineStep Make(const LocalFrame& frame, double dt_s, const Eigen::Vector3d& p_nominal_m);
};

}  // namespace dn
