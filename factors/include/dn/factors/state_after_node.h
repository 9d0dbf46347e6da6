#pragma once

#include <dn/geo/local_frame.h>
#include <dn/imu/preintegration.h>
#include <dn/imu/strapdown.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// Attitude body -> map, position in map (m) and velocity with respect to the Earth (m/s).
template <class T>
struct KinematicState {
  Eigen::Quaternion<T> q_mb;
  Eigen::Matrix<T, 3, 1> p_mb, v_m;
};

/// The state at an epoch after a node as a function of the state of the node. It is the building
/// block of factors on measurements between nodes.
///
///   R' = C^T R dR,   p' and v' as in AffineStep
///
/// with the increments dR, dv, dp from the node to the epoch, in the exact rotating-Earth form.
class StateAfterNode {
 public:
  StateAfterNode() = default;

  /// Creates the function. `partial` are the increments from the node to the epoch, corrected with
  /// the current biases. Gravitation is evaluated at p_nominal_m, the nominal position of the node.
  StateAfterNode(const LocalFrame& frame, const Preintegrated& partial,
                 const Eigen::Vector3d& p_nominal_m)
      : step_(AffineStep::Make(frame, partial.dt_s(), p_nominal_m)),
        q_C_inverse_(Exp(Eigen::Vector3d(-partial.dt_s() * frame.w_ie_m()))),
        delta_q_(partial.delta_q),
        delta_v_(partial.delta_v),
        delta_p_(partial.delta_p),
        w_ie_m_(frame.w_ie_m()),
        dt_s_(partial.dt_s()) {}

  template <class T>
  KinematicState<T> At(const Eigen::Quaternion<T>& q_mb, const Eigen::Matrix<T, 3, 1>& p_mb,
                       const Eigen::Matrix<T, 3, 1>& v_m) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    return At(q_mb, p_mb, v_m, Eigen::Quaternion<T>(delta_q_.template cast<T>()),
              Vec3(delta_v_.template cast<T>()), Vec3(delta_p_.template cast<T>()));
  }

  /// Returns the state for increments other than those of the constructor.
  template <class T>
  KinematicState<T> At(const Eigen::Quaternion<T>& q_mb, const Eigen::Matrix<T, 3, 1>& p_mb,
                       const Eigen::Matrix<T, 3, 1>& v_m, const Eigen::Quaternion<T>& delta_q,
                       const Eigen::Matrix<T, 3, 1>& delta_v,
                       const Eigen::Matrix<T, 3, 1>& delta_p) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const auto times = [](const Eigen::Matrix3d& M, const Vec3& x) {
      return Vec3(M.template cast<T>() * x);
    };
    const Eigen::Quaternion<T> q_C_inverse = q_C_inverse_.template cast<T>();
    const Vec3 R_dp = q_mb * delta_p;
    const Vec3 R_dv = q_mb * delta_v;
    return {q_C_inverse * q_mb * delta_q,
            times(step_.p_p, p_mb) + times(step_.p_v, v_m) + times(step_.p_d, R_dp) +
                step_.p_0.template cast<T>(),
            times(step_.v_p, p_mb) + times(step_.v_v, v_m) + times(step_.v_d, R_dp) +
                q_C_inverse * R_dv + step_.v_0.template cast<T>()};
  }

  /// Returns the same function with changed increments (tangent order of Preintegrated) and
  /// additional gravitation.
  StateAfterNode Moved(const Eigen::Matrix<double, 9, 1>& increments,
                       const Eigen::Vector3d& gravitation_mps2) const;

  /// Returns the Jacobian of position and velocity with respect to gravitation in addition to the
  /// normal one, map axes.
  Eigen::Matrix3d PositionGravitationJacobian() const;
  Eigen::Matrix3d VelocityGravitationJacobian() const;

  const AffineStep& step() const { return step_; }
  const Eigen::Quaterniond& delta_q() const { return delta_q_; }
  const Eigen::Vector3d& delta_v() const { return delta_v_; }
  const Eigen::Vector3d& delta_p() const { return delta_p_; }

 private:
  AffineStep step_;
  Eigen::Quaterniond q_C_inverse_ = Eigen::Quaterniond::Identity();
  Eigen::Quaterniond delta_q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d delta_v_ = Eigen::Vector3d::Zero(), delta_p_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_ie_m_ = Eigen::Vector3d::Zero();
  double dt_s_ = 0.0;
};

}  // namespace dn
