#pragma once

#include <dn/block.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>

namespace dn {

/// A rigid transform T_ab: x_a = q x_b + p, with p the origin of b in a.
template <class T>
struct Transform {
  using Vector3 = Eigen::Matrix<T, 3, 1>;

  Eigen::Quaternion<T> q = Eigen::Quaternion<T>::Identity();
  Vector3 p = Vector3::Zero();

  Transform() = default;
  Transform(const Eigen::Quaternion<T>& rotation, const Vector3& translation)
      : q(rotation), p(translation) {}
  /// Creates a transform from seven numbers: quaternion (x, y, z, w), translation.
  explicit Transform(const T* x) : q(x), p(x[4], x[5], x[6]) {}

  void Store(T* x) const {
    std::copy_n(q.coeffs().data(), 4, x);
    std::copy_n(p.data(), 3, x + 4);
  }

  /// Returns T_ba.
  Transform Inverse() const {
    const Eigen::Quaternion<T> q_ba = q.conjugate();
    return {q_ba, Vector3(-(q_ba * p))};
  }

  /// Returns the rotation vector (rad), then the translation.
  Eigen::Matrix<T, 6, 1> ToVector() const {
    Eigen::Matrix<T, 6, 1> v;
    v << Log(q), p;
    return v;
  }

  template <class U>
  Transform<U> cast() const {
    return {q.template cast<U>(), p.template cast<U>()};
  }
};

/// Returns T_ac from T_ab and T_bc. One of them may have scalar type double while the other is
/// differentiated.
template <class T, class U>
auto operator*(const Transform<T>& T_ab, const Transform<U>& T_bc) {
  using R = decltype(T() * U());
  const Transform<R> a = T_ab.template cast<R>(), b = T_bc.template cast<R>();
  return Transform<R>(a.q * b.q, typename Transform<R>::Vector3(a.q * b.p + a.p));
}

/// Returns x_a from x_b.
template <class T, class Derived>
auto operator*(const Transform<T>& T_ab, const Eigen::MatrixBase<Derived>& x_b) {
  using R = decltype(T() * typename Derived::Scalar());
  const Transform<R> a = T_ab.template cast<R>();
  const Eigen::Matrix<R, 3, 1> x = x_b.template cast<R>();
  return Eigen::Matrix<R, 3, 1>(a.q * x + a.p);
}

/// A pose as one block: quaternion (x, y, z, w) and translation. Its tangent (rotation,
/// translation) is that of the blocks Rotation and Vec<3>:
///
///   q_mb <- q_mb Exp(dphi_b),  p_mb <- p_mb + dp_m      dphi in rad about the axes of b, dp in m
struct Pose {
  using Value = Transform<double>;
  template <class T>
  using View = Transform<T>;
  static constexpr int kSize = 7;
  static constexpr int kTangentSize = 6;
  static void Plus(const double* x, const double* d, double* x_plus_d);
  static void Minus(const double* y, const double* x, double* y_minus_x);
  static void PlusJacobian(const double* x, double* J);
};

}  // namespace dn
