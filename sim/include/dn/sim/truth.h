#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory.h>
#include <dn/sim/disturbance.h>
#include <dn/sim/uniform_spline.h>

#include <Eigen/Core>
#include <memory>

namespace dn {

class DisturbanceTable;

/// Exact motion at one instant, and what ideal inertial sensors feel there.
struct TruthState {
  MapPose pose;
  Eigen::Vector3d a_m = Eigen::Vector3d::Zero();     ///< acceleration with respect to the Earth
  Eigen::Vector3d w_mb_b = Eigen::Vector3d::Zero();  ///< angular rate with respect to the Earth
  Eigen::Vector3d w_ib_b =
      Eigen::Vector3d::Zero();                    ///< angular rate with respect to inertial space
  Eigen::Vector3d f_b = Eigen::Vector3d::Zero();  ///< specific force
};

/// The normal Earth at a place.
struct NormalEarth {
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  Geodetic position;                                       ///< of p_m
  Eigen::Matrix3d R_mn = Eigen::Matrix3d::Identity();      ///< local NED -> map
  Eigen::Vector3d attraction_m = Eigen::Vector3d::Zero();  ///< m/s^2, in map axes

  static NormalEarth At(const LocalFrame& frame, const Eigen::Vector3d& p_m);
};

/// A smooth trajectory over the rotating Earth, with every derivative in closed form.
///
/// Position is the path at the time t + lead(t) plus the height disturbance; roll, pitch and
/// heading refer to the north-east-down of the point. With n that frame, w the Earth rate:
///
///   w_ib_b = R_bm w + R_bn w_en_n + E(roll, pitch) d/dt (roll, pitch, heading)
///   f_b    = R_bm (a + 2 w x v + w x (w x (r0 + p)) - attraction(p))
///
/// The path is C4, what the air adds C2: rates and forces are smooth. Thread-safe.
class TruthTrajectory {
 public:
  /// The path's times count from t_begin_s. Throws InvalidInput when the path, led by the
  /// disturbance, does not cover [t_begin_s, t_end_s].
  TruthTrajectory(LocalFrame frame, UniformSpline path, const Disturbance& disturbance,
                  double t_begin_s, double t_end_s);

  const LocalFrame& frame() const { return frame_; }
  double t_begin_s() const { return t_begin_s_; }
  double t_end_s() const { return t_end_s_; }

  /// t_s in [t_begin_s, t_end_s] (1 ms beyond is still defined); throws InvalidInput further out.
  MapPose Pose(double t_s) const;
  TruthState State(double t_s) const;
  /// The same, with the Earth at its place.
  TruthState State(double t_s, NormalEarth* earth) const;
  /// The same at a place between two others, with what the Earth is there in between: of 10 m apart
  /// to 1e-11 of it.
  TruthState StateBetween(const NormalEarth& a, const NormalEarth& b, double t_s) const;
  Eigen::Vector3d AngularRate(double t_s) const { return State(t_s).w_ib_b; }
  Eigen::Vector3d SpecificForce(double t_s) const { return State(t_s).f_b; }

  /// As navigation output: what a perfect system would have written.
  NavPoint Nav(double t_s) const;

 private:
  struct Motion {
    Eigen::Vector3d p, v, a;        // in m
    Eigen::Vector3d rph, rph_rate;  // roll, pitch, heading, rad and rad/s
  };
  Motion MotionAt(double t_s) const;
  TruthState StateOf(const Motion& motion, double t_s, const Eigen::Matrix3d& R_mn,
                     const Eigen::Vector3d& attraction_m) const;

  LocalFrame frame_;
  UniformSpline path_;
  std::shared_ptr<const DisturbanceTable> disturbance_;
  double t_begin_s_;
  double t_end_s_;
};

/// A true state as navigation output, with what ideal inertial sensors feel; `earth` is that of its
/// place.
NavPoint ToNavPoint(const TruthState& state, const NormalEarth& earth);

}  // namespace dn
