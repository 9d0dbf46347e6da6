#pragma once

#include <dn/factors/node_bridge.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/preintegration.h>
#include <dn/imu/strapdown.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>

namespace dn {

/// One end of a point pair: how to get from the node before the lidar epoch to the point.
struct LidarEnd {
  /// From the node to the lidar epoch, corrected with the current biases. IdentityIncrement where
  /// the epoch is the node's.
  Preintegrated partial;
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();          ///< laser vector in the sensor frame, m
  Eigen::Vector3d p_nominal_m = Eigen::Vector3d::Zero();  ///< of the node, for the attraction
  /// To the attitude of the node after the epoch; null: the increments stand by themselves.
  std::shared_ptr<const NodeBridge> bridge = {};
};

/// Covariance (m^2, map axes) that the white noise of the partial increments, less what a bridge
/// tells of it, adds to the georeferenced point: of R_mb (dR l_b + dp), rotation, position and
/// their correlation.
/// R_mb: attitude of the node; l_b: lever arm plus laser vector in body at the lidar epoch, m.
/// Add it for both ends to the covariance of the pair's difference.
Eigen::Matrix3d EndNoise(const LidarEnd& end, const Eigen::Matrix3d& R_mb,
                         const Eigen::Vector3d& l_b);

/// The point that a laser vector reaches, as a function of the node before its epoch and of the
/// mounting: what factors of lidar points are made of.
///
///   x = p' + R' l - ddt (v' + R' (w_b x l) - w_ie x (R' l)),   l = a_b + R_boresight u_b
///
/// where p', v', R' are propagated from the node (q_mb, p_mb, v_m) to the end of the partial
/// increments in the exact rotating-Earth form (AffineStep), w_b is the corrected angular rate
/// there, and ddt the part of the tag's delay for which the increments were not cut: the point
/// moves along its velocity with respect to the Earth.
class LidarPoint {
 public:
  LidarPoint() = default;
  LidarPoint(const LocalFrame& frame, const Preintegrated& partial,
             const Eigen::Vector3d& p_nominal_m);

  /// The point in map, m. u_b: laser vector in the body axes that the boresight turns, T_bs u_s.
  template <class T>
  Eigen::Matrix<T, 3, 1> At(const Eigen::Quaternion<T>& q, const Eigen::Matrix<T, 3, 1>& p,
                            const Eigen::Matrix<T, 3, 1>& v,
                            const Eigen::Quaternion<T>& q_boresight,
                            const Eigen::Matrix<T, 3, 1>& a_b, const Eigen::Matrix<T, 3, 1>& u_b,
                            const T& ddt) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const auto times = [](const Eigen::Matrix3d& M, const Vec3& x) {
      return Vec3(M.template cast<T>() * x);
    };
    const Eigen::Quaternion<T> q_Ci = q_C_inverse_.template cast<T>();
    const Eigen::Quaternion<T> q_end = q_Ci * q * delta_q_.template cast<T>();
    const Vec3 R_dp = q * Vec3(delta_p_.template cast<T>());
    const Vec3 R_dv = q * Vec3(delta_v_.template cast<T>());
    const Vec3 p_end = times(step_.p_p, p) + times(step_.p_v, v) + times(step_.p_d, R_dp) +
                       step_.p_0.template cast<T>();
    const Vec3 v_end = times(step_.v_p, p) + times(step_.v_v, v) + times(step_.v_d, R_dp) +
                       q_Ci * R_dv + step_.v_0.template cast<T>();
    const Vec3 l = a_b + q_boresight * u_b;
    const Vec3 R_l = q_end * l;
    const Vec3 rate = v_end + q_end * Vec3(w_b_.template cast<T>().cross(l)) -
                      w_ie_m_.template cast<T>().cross(R_l);
    return p_end + R_l - ddt * rate;
  }

  /// The values of the blocks that a point depends on.
  struct Arguments {
    Eigen::Quaterniond q_mb;
    Eigen::Vector3d p_mb, v_m;
    Eigen::Quaterniond q_boresight;
    Eigen::Vector3d a_b, u_b;
    double ddt_s = 0.0;
  };

  /// The point before its move by -ddt rate, that rate, and the Jacobians of the point after it.
  struct Derivatives {
    Eigen::Vector3d x, rate;
    Eigen::Matrix3d q;      ///< attitude of the node, right tangent
    Eigen::Matrix3d p, v;   ///< its position and velocity
    Eigen::Matrix3d theta;  ///< boresight, left tangent
    Eigen::Matrix3d a_b;    ///< lever arm; the same for the turned laser vector R_boresight u_b
  };
  Derivatives DifferentiateAt(const Arguments& at) const;

  /// Of the point with respect to the partial increments: rotation (right, at the end), velocity,
  /// position.
  Eigen::Matrix<double, 3, 9> ByIncrements(const Arguments& at) const;

  /// Of the point with respect to an attraction beyond the normal one, map axes.
  Eigen::Matrix3d ByAttraction(double ddt_s) const;

  /// The same end with other increments (tangent of ByIncrements) and another attraction.
  LidarPoint Moved(const Eigen::Matrix<double, 9, 1>& increments,
                   const Eigen::Vector3d& attraction_mps2) const;

 private:
  AffineStep step_;
  Eigen::Quaterniond q_C_inverse_ = Eigen::Quaterniond::Identity();
  Eigen::Quaterniond delta_q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d delta_v_, delta_p_, w_b_, w_ie_m_;
  double dt_s_ = 0.0;
};

}  // namespace dn
