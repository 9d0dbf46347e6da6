#pragma once

#include <dn/factors/state_after_node.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/preintegration.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// The georeferenced point of a laser vector as a function of the node before its epoch and of the
/// mounting. It is the building block of factors on lidar points.
///
///   x = p' + R' l - ddt (v' + R' (w_b x l) - w_ie x (R' l)),   l = a_b + R_boresight u_b
///
/// p', v', R' are the StateAfterNode (q_mb, p_mb, v_m) at the end of the partial increments, and
/// w_b is the corrected angular rate there. ddt is the part of the tag's delay that the end of the
/// increments does not include. The point is moved by -ddt times its velocity with respect to the
/// Earth.
class LidarPoint {
 public:
  LidarPoint() = default;
  LidarPoint(const LocalFrame& frame, const Preintegrated& partial,
             const Eigen::Vector3d& p_nominal_m);

  /// Returns the point in map, m. u_b is the laser vector in the body axes before rotation by the
  /// boresight, R_bs_nominal u_s.
  template <class T>
  Eigen::Matrix<T, 3, 1> At(const Eigen::Quaternion<T>& q, const Eigen::Matrix<T, 3, 1>& p,
                            const Eigen::Matrix<T, 3, 1>& v,
                            const Eigen::Quaternion<T>& q_boresight,
                            const Eigen::Matrix<T, 3, 1>& a_b, const Eigen::Matrix<T, 3, 1>& u_b,
                            const T& ddt) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const KinematicState<T> end = state_.At(q, p, v);
    const Vec3 l = a_b + q_boresight * u_b;
    const Vec3 R_l = end.q_mb * l;
    const Vec3 rate = end.v_m + end.q_mb * Vec3(w_b_.template cast<T>().cross(l)) -
                      w_ie_m_.template cast<T>().cross(R_l);
    return end.p_mb + R_l - ddt * rate;
  }

  /// Values of the blocks that a point depends on.
  struct Arguments {
    Eigen::Quaterniond q_mb;
    Eigen::Vector3d p_mb, v_m;
    Eigen::Quaterniond q_boresight;
    Eigen::Vector3d a_b, u_b;
    double ddt_s = 0.0;
  };

  /// The point before the shift by -ddt rate, that rate, and the Jacobians of the shifted point.
  struct Derivatives {
    Eigen::Vector3d x, rate;
    Eigen::Matrix3d q;      ///< with respect to the attitude of the node, right tangent
    Eigen::Matrix3d p, v;   ///< with respect to the position and velocity of the node
    Eigen::Matrix3d theta;  ///< with respect to the boresight, left tangent
    /// With respect to the lever arm, or equally the rotated laser vector R_boresight u_b.
    Eigen::Matrix3d a_b;
  };
  Derivatives DifferentiateAt(const Arguments& at) const;

  /// Returns the Jacobian of the point with respect to the partial increments: rotation (right, at
  /// the end), velocity, position.
  Eigen::Matrix<double, 3, 9> IncrementJacobian(const Arguments& at) const;

  /// Returns the Jacobian of the point with respect to gravitation in addition to the normal one,
  /// map axes.
  Eigen::Matrix3d GravitationJacobian(double ddt_s) const;

  /// Returns the same point with changed increments (tangent of IncrementJacobian) and additional
  /// gravitation.
  LidarPoint Moved(const Eigen::Matrix<double, 9, 1>& increments,
                   const Eigen::Vector3d& gravitation_mps2) const;

 private:
  StateAfterNode state_;
  Eigen::Vector3d w_b_, w_ie_m_;
};

}  // namespace dn
