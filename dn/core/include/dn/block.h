#pragma once

#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn {

/// Storage and perturbation of the unknowns of a block. Covariances always refer to the tangent
/// coordinates named here.
enum class Parametrisation {
  kVector,         ///< x <- x + d
  kRotationRight,  ///< q <- q Exp(d), d a rotation vector in rad in the source frame of q
  kRotationLeft,   ///< q <- Exp(d) q, d a rotation vector in rad in the target frame of q
  kManifold,       ///< by the functions of BlockKind::manifold: a pose, or a user's own kind
};

/// Functions of a block kind that is neither a vector nor a rotation.
class ManifoldFunctions {
 public:
  virtual void Plus(const double* x, const double* d, double* x_plus_d) const = 0;
  virtual void Minus(const double* y, const double* x, double* y_minus_x) const = 0;
  /// Writes d Plus / d d at d = 0, row-major, stored size x tangent size.
  virtual void PlusJacobian(const double* x, double* J) const = 0;
  /// Returns false if Minus is only an approximation.
  virtual bool has_exact_minus() const { return true; }

 protected:
  ~ManifoldFunctions() = default;
};

/// Run-time description of a block kind. The functions of its manifold must outlive all blocks of
/// the kind.
struct BlockKind {
  Parametrisation parametrisation = Parametrisation::kVector;
  int stored_size = 0;
  int tangent_size = 0;
  const ManifoldFunctions* manifold = nullptr;  ///< only for kManifold

  friend bool operator==(const BlockKind&, const BlockKind&) = default;
};

/// Unit quaternion (x, y, z, w) perturbed from the right by the full-angle rotation vector in rad:
/// q_mb <- q_mb Exp(dphi_b). Used for attitudes.
struct Rotation {
  using Value = Eigen::Quaterniond;
  template <class T>
  using View = Eigen::Map<const Eigen::Quaternion<T>>;
  static constexpr int kSize = 4;
  static constexpr int kTangentSize = 3;
  static constexpr BlockKind kKind{Parametrisation::kRotationRight, 4, 3};
};

/// Unit quaternion (x, y, z, w) perturbed from the left: q <- Exp(dtheta) q. Used for the
/// boresight, so that its covariance is that of the reported angles about the body axes.
struct LeftRotation {
  using Value = Eigen::Quaterniond;
  template <class T>
  using View = Eigen::Map<const Eigen::Quaternion<T>>;
  static constexpr int kSize = 4;
  static constexpr int kTangentSize = 3;
  static constexpr BlockKind kKind{Parametrisation::kRotationLeft, 4, 3};
};

/// N real numbers, perturbed by addition.
template <int N>
struct Vec {
  using Value = Eigen::Matrix<double, N, 1>;
  template <class T>
  using View = Eigen::Map<const Eigen::Matrix<T, N, 1>>;
  static constexpr int kSize = N;
  static constexpr int kTangentSize = N;
  static constexpr BlockKind kKind{Parametrisation::kVector, N, N};
};

/// One real number; its value and view are plain numbers.
struct Scalar {
  using Value = double;
  static constexpr int kSize = 1;
  static constexpr int kTangentSize = 1;
  static constexpr BlockKind kKind{Parametrisation::kVector, 1, 1};
};

/// Returns the kind of n real numbers, n known at run time.
constexpr BlockKind VectorKind(int n) { return {Parametrisation::kVector, n, n}; }

/// Computes x (+) d in the parametrisation of `kind`; the quaternion of a rotation is normalised.
/// The arrays have sizes stored_size, tangent_size and stored_size.
void Plus(const BlockKind& kind, const double* x, const double* d, double* x_plus_d);

/// Computes y (-) x, so that Plus(x, Minus(y, x)) = y.
void Minus(const BlockKind& kind, const double* y, const double* x, double* y_minus_x);

/// Returns d Minus(Plus(y, d), x) / d d at d = 0, tangent_size x tangent_size; numerical for a kind
/// with functions of its own.
Eigen::MatrixXd MinusJacobian(const BlockKind& kind, const double* y, const double* x);

/// Returns d Plus(x, d) / d d at d = 0, stored_size x tangent_size.
Eigen::MatrixXd PlusJacobian(const BlockKind& kind, const double* x);

/// Returns a left inverse of PlusJacobian, tangent_size x stored_size. It converts a Jacobian in
/// the tangent to one in stored coordinates.
Eigen::MatrixXd TangentLift(const BlockKind& kind, const double* x);

/// Returns the 4 x 3 PlusJacobian of a rotation block, without allocation.
Eigen::Matrix<double, 4, 3> RotationPlusJacobian(Parametrisation parametrisation, const double* q);

/// Converts a Jacobian with respect to stored coordinates to one with respect to the tangent,
/// written to `out`.
template <class Stored, class Out>
void StoredToTangent(const BlockKind& kind, const double* x,
                     const Eigen::MatrixBase<Stored>& stored, Out&& out) {
  switch (kind.parametrisation) {
    case Parametrisation::kVector:
      out = stored;
      break;
    case Parametrisation::kRotationRight:
    case Parametrisation::kRotationLeft:
      out.template leftCols<3>().noalias() =
          stored.lazyProduct(RotationPlusJacobian(kind.parametrisation, x));
      break;
    case Parametrisation::kManifold:
      out.noalias() = stored * PlusJacobian(kind, x);
      break;
  }
}

}  // namespace dn
