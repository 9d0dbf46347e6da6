#pragma once

#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// How the unknowns of a block are stored and how they are perturbed. Covariances always refer to
/// the tangent coordinates named here.
enum class Parametrisation {
  kVector,         ///< x <- x + d
  kRotationRight,  ///< q <- q Exp(d), d a rotation vector in rad in the frame that q rotates from
  kRotationLeft,   ///< q <- Exp(d) q, d a rotation vector in rad in the frame that q rotates to
};

/// A block kind known at run time.
struct BlockKind {
  Parametrisation parametrisation = Parametrisation::kVector;
  int stored_size = 0;
  int tangent_size = 0;

  friend bool operator==(const BlockKind&, const BlockKind&) = default;
};

/// Unit quaternion (x, y, z, w) perturbed from the right by the full-angle rotation vector in rad:
/// q_mb <- q_mb Exp(dphi_b). For attitudes.
struct Rotation {
  using Value = Eigen::Quaterniond;
  static constexpr int kSize = 4;
  static constexpr int kTangentSize = 3;
  static constexpr BlockKind kKind{Parametrisation::kRotationRight, 4, 3};
};

/// Unit quaternion (x, y, z, w) perturbed from the left: q <- Exp(dtheta) q. For the boresight,
/// whose covariance is then that of the reported angles about the body axes.
struct LeftRotation {
  using Value = Eigen::Quaterniond;
  static constexpr int kSize = 4;
  static constexpr int kTangentSize = 3;
  static constexpr BlockKind kKind{Parametrisation::kRotationLeft, 4, 3};
};

/// N real numbers, perturbed by addition.
template <int N>
struct Vec {
  using Value = Eigen::Matrix<double, N, 1>;
  static constexpr int kSize = N;
  static constexpr int kTangentSize = N;
  static constexpr BlockKind kKind{Parametrisation::kVector, N, N};
};

/// x (+) d in the parametrisation of `kind`; quaternions are normalised. Arrays of stored_size,
/// tangent_size and stored_size.
void Plus(const BlockKind& kind, const double* x, const double* d, double* x_plus_d);

/// y (-) x, so that Plus(x, Minus(y, x)) = y.
void Minus(const BlockKind& kind, const double* y, const double* x, double* y_minus_x);

/// d Plus(x, d) / d d at d = 0, stored_size by tangent_size.
Eigen::MatrixXd PlusJacobian(const BlockKind& kind, const double* x);

/// The 4 x 3 PlusJacobian of a rotation block, without allocation.
Eigen::Matrix<double, 4, 3> RotationPlusJacobian(Parametrisation parametrisation, const double* q);

}  // namespace dn
