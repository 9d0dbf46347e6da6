#pragma once

#include <dn/block.h>
#include <dn/error.h>
#include <dn/factor.h>
#include <dn/noise.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// Known value of a vector block.
///
///   r = W (x - z)                                                   [N], unitless
///
///   block | symbol | stored | tangent | meaning
///   ------|--------|--------|---------|------------------------------------------
///     0   | x      |   N    |    N    | the vector, in the unit of z
///
/// Jacobian: W.
template <int N>
class PriorVector final : public Factor<PriorVector<N>, N, Vec<N>> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  /// Creates the prior with mean z. Throws InvalidInput if z is not finite.
  PriorVector(const Vector& z, const Noise<N>& noise) : z_(z), W_(noise.sqrt_information()) {
    if (!z.allFinite()) throw InvalidInput("value of a prior is not finite");
  }

  template <class T>
  bool Residual(const T* x_data, T* r_data) const {
    const Eigen::Map<const Eigen::Matrix<T, N, 1>> x(x_data);
    Eigen::Map<Eigen::Matrix<T, N, 1>> r(r_data);
    r = W_.template cast<T>() * (x - z_.template cast<T>());
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    this->template Put<0>(x, J, W_);
    return Residual(x[0], r);
  }

 private:
  Vector z_;
  Eigen::Matrix<double, N, N> W_;
};

/// Known value of a rotation with right perturbation; the noise is in the frame that it rotates
/// from.
///
///   r = W Log(q0^-1 q)                                              [3], unitless
///
///   block | symbol | stored | tangent | meaning
///   ------|--------|--------|---------|------------------------------------------
///     0   | q      |   4    |    3    | the rotation, (x, y, z, w)
///
/// Jacobian (right, rad): W Jr^-1(Log(q0^-1 q)). The residual is discontinuous at half a turn
/// between q and q0.
class PriorRotation final : public Factor<PriorRotation, 3, Rotation> {
 public:
  /// Creates the prior with mean q0; `noise` is in rad. Throws InvalidInput if q0 is not finite or
  /// has zero norm.
  PriorRotation(const Eigen::Quaterniond& q0, const Noise<3>& noise);

  template <class T>
  bool Residual(const T* q_data, T* r_data) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(q_data);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(r_data);
    r = W_.cast<T>() * Log(Eigen::Quaternion<T>(q0_inverse_.cast<T>() * q));
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

 private:
  Eigen::Quaterniond q0_inverse_;
  Eigen::Matrix3d W_;
};

/// Known value of a rotation with left perturbation (the boresight); the noise is in the frame that
/// it rotates to.
///
///   r = W Log(q q0^-1)                                              [3], unitless
///
///   block | symbol | stored | tangent | meaning
///   ------|--------|--------|---------|------------------------------------------
///     0   | q      |   4    |    3    | the rotation, (x, y, z, w)
///
/// Jacobian (left, rad): W Jl^-1(Log(q q0^-1)), with Jl(phi) = Jr(-phi). The residual is
/// discontinuous at half a turn between q and q0.
class PriorLeftRotation final : public Factor<PriorLeftRotation, 3, LeftRotation> {
 public:
  /// Creates the prior with mean q0; `noise` is in rad. Throws InvalidInput if q0 is not finite or
  /// has zero norm.
  PriorLeftRotation(const Eigen::Quaterniond& q0, const Noise<3>& noise);

  template <class T>
  bool Residual(const T* q_data, T* r_data) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(q_data);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(r_data);
    r = W_.cast<T>() * Log(Eigen::Quaternion<T>(q * q0_inverse_.cast<T>()));
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

 private:
  Eigen::Quaterniond q0_inverse_;
  Eigen::Matrix3d W_;
};

}  // namespace dn
