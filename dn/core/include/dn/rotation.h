#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace dn {

/// Returns the cross-product matrix of any 3-vector expression: Skew(a) b = a x b.
template <class Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 3> Skew(const Eigen::MatrixBase<Derived>& vector) {
  using T = typename Derived::Scalar;
  const Eigen::Matrix<T, 3, 1> a = vector;
  Eigen::Matrix<T, 3, 3> S;
  S << T(0), -a.z(), a.y(), a.z(), T(0), -a.x(), -a.y(), a.x(), T(0);
  return S;
}

/// Returns the quaternion of the rotation vector phi (rad): Exp([phi]x). Accurate at every angle
/// and differentiable at 0.
template <class T>
Eigen::Quaternion<T> Exp(const Eigen::Matrix<T, 3, 1>& phi) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T angle2 = phi.squaredNorm();
  T half_sinc, c;
  if (angle2 > T(1e-8)) {
    const T angle = sqrt(angle2);
    half_sinc = sin(angle / T(2)) / angle;
    c = cos(angle / T(2));
  } else {  // series with relative error 1e-18 at |phi| = 1e-4
    half_sinc = T(0.5) - angle2 / T(48) + angle2 * angle2 / T(3840);
    c = T(1) - angle2 / T(8) + angle2 * angle2 / T(384);
  }
  return Eigen::Quaternion<T>(c, half_sinc * phi.x(), half_sinc * phi.y(), half_sinc * phi.z());
}

/// Returns the rotation vector (rad, |phi| <= pi) of the quaternion q; inverse of Exp. q need not
/// be exactly normalised and may have either sign.
template <class T>
Eigen::Matrix<T, 3, 1> Log(const Eigen::Quaternion<T>& q) {
  using std::atan2;
  using std::sqrt;
  const T sign = q.w() < T(0) ? T(-1) : T(1);
  const T w = sign * q.w();
  const Eigen::Matrix<T, 3, 1> v = sign * q.vec();
  const T v2 = v.squaredNorm();
  if (v2 > T(1e-16) * w * w) {
    const T n = sqrt(v2);
    return (T(2) * atan2(n, w) / n) * v;
  }
  const T ratio2 = v2 / (w * w);
  return (T(2) / w) * (T(1) - ratio2 / T(3)) * v;
}

/// Returns the right Jacobian of SO(3): Exp(phi + d) = Exp(phi) Exp(RightJacobian(phi) d) to first
/// order in d.
Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& phi);

/// Returns the inverse of RightJacobian: Log(Exp(phi) Exp(d)) = phi + RightJacobianInverse(phi) d
/// to first order.
Eigen::Matrix3d RightJacobianInverse(const Eigen::Vector3d& phi);

/// Returns the rotation body -> local NED from roll, pitch, heading (rad) in the SBET order Rz(y)
/// Ry(p) Rx(r).
Eigen::Quaterniond QuaternionFromRollPitchHeading(const Eigen::Vector3d& rph_rad);

/// Returns roll, pitch, heading (rad; heading in (-pi, pi]) of a rotation body -> NED. Inverse of
/// QuaternionFromRollPitchHeading except at |pitch| = pi/2.
Eigen::Vector3d RollPitchHeading(const Eigen::Quaterniond& q_nb);

/// Returns E, the rotation vector about the body axes per change of roll, pitch, heading: R_nb(rph
/// + d) = R_nb(rph) Exp(E d) to first order. down_b is the local down direction in body axes, the
/// third row of R_nb. Singular at |pitch| = pi/2, where roll is taken as 0.
inline Eigen::Matrix3d BodyFromEulerRates(const Eigen::Vector3d& down_b) {
  const double cos_pitch = down_b.tail<2>().norm();
  const double scale = cos_pitch > 0.0 ? 1.0 / cos_pitch : 0.0;
  Eigen::Matrix3d E;
  E << 1.0, 0.0, down_b.x(),                                        //
      0.0, cos_pitch > 0.0 ? scale * down_b.z() : 1.0, down_b.y(),  //
      0.0, -scale * down_b.y(), down_b.z();
  return E;
}

}  // namespace dn
