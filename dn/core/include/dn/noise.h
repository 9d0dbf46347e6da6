#pragma once

#include <dn/eigen_alignment.h>
#include <dn/error.h>
#include <dn/fixed_size.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <string>

namespace dn {

/// Gaussian measurement noise of dimension N. It is stored as the square-root information W with
/// W^T W = covariance^-1, so that W (measured - predicted) is unitless with unit covariance.
///
/// Every object is valid: the constructors throw InvalidInput for values that are not finite or not
/// positive definite.
template <int N>
class Noise {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// Creates noise with the same standard deviation for every component, in the unit of the
  /// measurement.
  static Noise Sigma(double sigma) { return Sigma(Vector(Vector::Constant(sigma))); }

  /// Creates noise with one standard deviation per component, in the unit of the measurement.
  static Noise Sigma(const Vector& sigma) {
    for (int i = 0; i < N; ++i) {
      if (!(sigma[i] > 0.0) || !std::isfinite(sigma[i])) {
        throw InvalidInput("standard deviation " + std::to_string(i) + " of " + std::to_string(N) +
                           " is " + std::to_string(sigma[i]) + ", must be positive and finite");
      }
    }
    return Noise(Matrix(sigma.cwiseInverse().asDiagonal()));
  }
  template <class Derived>
  static Noise Sigma(const Eigen::MatrixBase<Derived>& sigma) {
    return Sigma(core_internal::FixedSize<N, 1>(sigma, "vector of standard deviations"));
  }

  /// Creates noise from a full covariance, which must be positive definite and symmetric to 1e-9 of
  /// the product of the two standard deviations.
  static Noise Covariance(const Matrix& covariance) {
    return Noise(Factored(covariance, "covariance").matrixL().solve(Matrix::Identity()));
  }
  template <class Derived>
  static Noise Covariance(const Eigen::MatrixBase<Derived>& covariance) {
    return Covariance(core_internal::FixedSize<N, N>(covariance, "covariance"));
  }

  /// Creates noise from a full information matrix, the inverse of the covariance, with the same
  /// conditions.
  static Noise Information(const Matrix& information) {
    return Noise(Matrix(Factored(information, "information matrix").matrixU()));
  }
  template <class Derived>
  static Noise Information(const Eigen::MatrixBase<Derived>& information) {
    return Information(core_internal::FixedSize<N, N>(information, "information matrix"));
  }

  /// Returns the square-root information matrix W.
  const Matrix& sqrt_information() const { return W_; }

  /// Returns the covariance (W^T W)^-1.
  Matrix covariance() const {
    const Matrix W_inverse = W_.inverse();
    return W_inverse * W_inverse.transpose();
  }

 private:
  explicit Noise(const Matrix& W) : W_(W) {
    if (!W.allFinite()) {
      throw InvalidInput("noise of dimension " + std::to_string(N) +
                         " is too small: its inverse is not finite");
    }
  }

  static Eigen::LLT<Matrix> Factored(const Matrix& M, const char* what) {
    Eigen::LLT<Matrix> llt(M);
    if (!M.allFinite() || !IsSymmetric(M) || llt.info() != Eigen::Success ||
        !(Matrix(llt.matrixL()).diagonal().minCoeff() > 0.0)) {
      throw InvalidInput(std::string(what) + " of dimension " + std::to_string(N) +
                         " is not symmetric, positive definite and finite");
    }
    return llt;
  }

  static bool IsSymmetric(const Matrix& M) {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < i; ++j) {
        const double scale = std::sqrt(std::abs(M(i, i) * M(j, j)));
        if (!(std::abs(M(i, j) - M(j, i)) <= 1e-9 * scale)) return false;
      }
    }
    return true;
  }

  Matrix W_;
};

}  // namespace dn
