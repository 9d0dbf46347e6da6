#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory.h>
#include <dn/sim/disturbance.h>
#include <dn/sim/uniform_spline.h>

#include <Eigen/Core>
#include <memory>

namespace dn {

class DisturbanceTable;
class PlatformVibration;

/// Exact motion at one instant, and the measurements of ideal inertial sensors.
struct TruthState {
  MapPose pose;
  Eigen::Vector3d a_m = Eigen::Vector3d::Zero();     ///< acceleration with respect to the Earth
  Eigen::Vector3d w_mb_b = Eigen::Vector3d::Zero();  ///< angular rate with respect to the Earth
  /// Angular rate with respect to inertial space.
  Eigen::Vector3d w_ib_b = Eigen::Vector3d::Zero();
  Eigen::Vector3d f_b = Eigen::Vector3d::Zero();  ///< specific force
};

/// Normal gravity field and local axes at a point.
struct NormalEarth {
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  Geodetic position;                                        ///< geodetic coordinates of p_m
  Eigen::Matrix3d R_mn = Eigen::Matrix3d::Identity();       ///< local NED to map
  Eigen::Vector3d gravitation_m = Eigen::Vector3d::Zero();  ///< gravitation, m/s^2, in map axes

  /// Returns the normal Earth at a point in map.
  static NormalEarth At(const LocalFrame& frame, const Eigen::Vector3d& p_m);
};

/// Smooth trajectory over the rotating Earth, with all derivatives in closed form.
///
/// The position is that of the path at the time t + lead(t), plus the height disturbance. Roll,
/// pitch and heading refer to the north-east-down axes at the point. With n for these axes and w
/// for the Earth rate:
///
///   w_ib_b = R_bm w + R_bn w_en_n + E(roll, pitch) d/dt (roll, pitch, heading)
///   f_b    = R_bm (a + 2 w x v + w x (w x (r0 + p)) - gravitation(p))
///
/// The path has four continuous derivatives and the disturbance has two, so that rates and forces
/// are smooth. Vibration moves the body by a displacement d and a rotation vector in its own axes:
///
///   p_mb = p0 + R0 d,   R_mb = R0 Exp(turn)
///
/// The class is thread-safe.
class TruthTrajectory {
 public:
  /// The times of the path count from t_begin_s. Throws InvalidInput if the path with the lead of
  /// the disturbance does not cover [t_begin_s, t_end_s].
  TruthTrajectory(LocalFrame frame, UniformSpline path, const Disturbance& disturbance,
                  double t_begin_s, double t_end_s,
                  std::shared_ptr<const PlatformVibration> vibration = nullptr);

  const LocalFrame& frame() const { return frame_; }
  double t_begin_s() const { return t_begin_s_; }
  double t_end_s() const { return t_end_s_; }
  /// Returns the highest frequency of the vibration, Hz; 0 without vibration.
  double vibration_hz() const;

  /// The functions below accept t_s in [t_begin_s, t_end_s] plus 1 ms on either side; they throw
  /// InvalidInput outside.
  MapPose Pose(double t_s) const;
  TruthState State(double t_s) const;
  /// Returns the state and sets `earth` for its position.
  TruthState State(double t_s, NormalEarth* earth) const;
  /// Returns the state at a position between `a` and `b`, with the Earth interpolated between them.
  /// For a distance of 10 m the relative error is 1e-11.
  TruthState StateBetween(const NormalEarth& a, const NormalEarth& b, double t_s) const;
  Eigen::Vector3d AngularRate(double t_s) const { return State(t_s).w_ib_b; }
  Eigen::Vector3d SpecificForce(double t_s) const { return State(t_s).f_b; }

  /// Returns the state as the output of a perfect navigation system.
  NavPoint Nav(double t_s) const;

 private:
  /// Position and angles of the flight, with their derivatives.
  struct Motion {
    Eigen::Vector3d p, v, a;                   // in m
    Eigen::Vector3d rph, rph_rate, rph_accel;  // roll, pitch, heading, rad, rad/s, rad/s^2
  };
  Motion MotionAt(double t_s) const;
  /// Adds the vibration to the pose, the acceleration and the rate of a state.
  void Shake(const Motion& motion, TruthState* state) const;
  TruthState ComputeState(const Motion& motion, double t_s, const Eigen::Matrix3d& R_mn,
                          const Eigen::Vector3d& gravitation_m) const;

  LocalFrame frame_;
  UniformSpline path_;
  std::shared_ptr<const DisturbanceTable> disturbance_;
  std::shared_ptr<const PlatformVibration> vibration_;  // null without vibration
  double t_begin_s_;
  double t_end_s_;
};

/// Converts a true state to navigation output, with the measurements of ideal inertial sensors.
/// `earth` must be that of its position.
NavPoint ToNavPoint(const TruthState& state, const NormalEarth& earth);

}  // namespace dn
