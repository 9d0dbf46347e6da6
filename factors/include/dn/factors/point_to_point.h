#pragma once

#include <dn/factor.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/preintegration.h>
#include <dn/imu/strapdown.h>
#include <dn/noise.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <utility>

namespace dn {

/// One end of a point pair: how to get from the node before the lidar epoch to the point.
struct LidarEnd {
  /// From the node to the lidar epoch, corrected with the current biases. IdentityIncrement where
  /// the epoch is the node's.
  Preintegrated partial;
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();          ///< laser vector in the sensor frame, m
  Eigen::Vector3d p_nominal_m = Eigen::Vector3d::Zero();  ///< of the node, for the attraction
};

/// Covariance (m^2, map axes) that the white noise of the partial increments adds to the
/// georeferenced point: of R_mb (dR l_b + dp), rotation, position and their correlation.
/// R_mb: attitude of the node; l_b: lever arm plus laser vector in body at the lidar epoch, m.
/// Add it for both ends to the covariance of the pair's difference.
Eigen::Matrix3d EndNoise(const LidarEnd& end, const Eigen::Matrix3d& R_mb,
                         const Eigen::Vector3d& l_b);

/// One ground point seen at two epochs.
///
///   r   = W (x_i - x_j)                                                       [3], unitless
///   x_k = p' + R' l - (dt - dt_nominal) (v' + R' (w_b x l) - w_ie x (R' l)),
///   l   = a_b + R_boresight T_bs u_s
///
/// where p', v', R' are propagated from the node of that end to the lidar epoch by the partial
/// increments, in the exact rotating-Earth form (AffineStep), and w_b is the corrected angular rate
/// at the epoch. The file's time tag is t + dt: the partial increments end at tag - dt_nominal, and
/// a change of dt moves the point along its velocity with respect to the Earth.
///
///   block | symbol      | stored | tangent | meaning
///   ------|-------------|--------|---------|-----------------------------------------------------
///    0, 3 | q_mb        |   4    |    3    | rotation body -> map of the node at i, j, (x, y, z,
///    w) 1, 4 | p_mb        |   3    |    3    | body origin in map of the node, m 2, 5 | v_m |   3
///    |    3    | velocity with respect to the Earth of the node, m/s
///     6   | q_boresight |   4    |    3    | Exp(theta), left of T_bs, about the body axes
///     7   | a_b         |   3    |    3    | lidar lever arm in body, m
///     8   | dt          |   1    |    1    | time offset of the lidar tags, s
///
/// Jacobians are analytic; the tangent of the boresight is left, of the attitudes right, rad.
/// The biases are not blocks of this edge: the partial increments are corrected at their
/// linearisation and integrated again when the biases move. Over at most a second the dropped term
/// is below the white noise of the increments themselves (EndNoise).
/// Degenerate when: both ends share the attitude (boresight and lever arm cancel).
/// Source: Brun & Skaloud, eq. (1) and the point-to-point observation, for any lidar epoch.
class PointToPoint final : public Factor<PointToPoint, 3, Rotation, Vec<3>, Vec<3>, Rotation,
                                         Vec<3>, Vec<3>, LeftRotation, Vec<3>, Vec<1>> {
 public:
  /// T_bs_nominal: mounting matrix sensor -> body. dt_nominal_s: the offset with which the partial
  /// increments were cut. noise_m: of the difference of the two points in map axes.
  /// Throws InvalidInput when a laser vector is zero or not finite, a nominal position, the
  /// mounting matrix or the offset is not finite, or the mounting matrix is no rotation (1e-6).
  PointToPoint(const LocalFrame& frame, const LidarEnd& i, const LidarEnd& j,
               const Eigen::Matrix3d& T_bs_nominal, double dt_nominal_s, const Noise<3>& noise_m);

  template <class T>
  bool Residual(const T* q_i, const T* p_i, const T* v_i, const T* q_j, const T* p_j, const T* v_j,
                const T* q_boresight_data, const T* a_b_data, const T* dt_data, T* r_data) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q_boresight(q_boresight_data);
    const Eigen::Map<const Vec3> a_b(a_b_data);
    const T ddt = dt_data[0] - T(dt_nominal_s_);
    const Vec3 x_i = Point<T>(i_, q_i, p_i, v_i, q_boresight, a_b, ddt);
    const Vec3 x_j = Point<T>(j_, q_j, p_j, v_j, q_boresight, a_b, ddt);
    Eigen::Map<Vec3> r(r_data);
    r.noalias() = W_.template cast<T>() * (x_i - x_j);
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

  /// The two georeferenced points in map, m, at the given blocks (first x_i, then x_j).
  std::pair<Eigen::Vector3d, Eigen::Vector3d> Points(double const* const* x) const;

  /// How the residual depends on what one end alone measures: the way in for effects that are no
  /// blocks of this factor.
  struct EndDerivatives {
    Eigen::Matrix3d J_r_u;  ///< with respect to the laser vector in body axes, 1/m
    Eigen::Vector3d J_r_t;  ///< to a late tag of this end (tag = t + dt), 1/s
    Eigen::Vector3d u_b;    ///< laser vector in body, R_boresight T_bs u_s, m
  };
  std::pair<EndDerivatives, EndDerivatives> DerivativesOfEnds(double const* const* x) const;

 private:
  struct End {
    AffineStep step;
    Eigen::Quaterniond q_C_inverse, delta_q;
    Eigen::Vector3d delta_v, delta_p, w_b, u_b;  // u_b: T_bs_nominal u_s
  };
  struct EndJacobians;

  template <class T>
  Eigen::Matrix<T, 3, 1> Point(const End& end, const T* q_data, const T* p_data, const T* v_data,
                               const Eigen::Quaternion<T>& q_boresight,
                               const Eigen::Matrix<T, 3, 1>& a_b, const T& ddt) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const auto times = [](const Eigen::Matrix3d& M, const Vec3& x) {
      return Vec3(M.template cast<T>() * x);
    };
    const Eigen::Quaternion<T> q(q_data);
    const Vec3 p(p_data[0], p_data[1], p_data[2]), v(v_data[0], v_data[1], v_data[2]);
    const Eigen::Quaternion<T> q_Ci = end.q_C_inverse.template cast<T>();
    const Eigen::Quaternion<T> q_end = q_Ci * q * end.delta_q.template cast<T>();
    const Vec3 R_dp = q * Vec3(end.delta_p.template cast<T>());
    const Vec3 R_dv = q * Vec3(end.delta_v.template cast<T>());
    const AffineStep& step = end.step;
    const Vec3 p_end = times(step.p_p, p) + times(step.p_v, v) + times(step.p_d, R_dp) +
                       step.p_0.template cast<T>();
    const Vec3 v_end = times(step.v_p, p) + times(step.v_v, v) + times(step.v_d, R_dp) +
                       q_Ci * R_dv + step.v_0.template cast<T>();
    const Vec3 l = a_b + q_boresight * Vec3(end.u_b.template cast<T>());
    const Vec3 R_l = q_end * l;
    const Vec3 rate = v_end + q_end * Vec3(end.w_b.template cast<T>().cross(l)) -
                      w_ie_m_.template cast<T>().cross(R_l);
    return p_end + R_l - ddt * rate;
  }

  static End MakeEnd(const LocalFrame& frame, const LidarEnd& end, const Eigen::Matrix3d& T_bs);
  EndJacobians JacobiansOf(const End& end, double const* const* node, double const* const* x) const;

  End i_, j_;
  Eigen::Vector3d w_ie_m_;
  double dt_nominal_s_;
  Eigen::Matrix3d W_;
};

}  // namespace dn
