#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>

namespace dn {

/// Eigenvalues and eigenvectors of a symmetric matrix.
struct SymmetricEigen {
  /// Decomposes A; only its lower triangle is read.
  explicit SymmetricEigen(const Eigen::MatrixXd& A);

  Eigen::VectorXd values;   ///< in ascending order
  Eigen::MatrixXd vectors;  ///< orthonormal columns, in the order of the values
};

}  // namespace dn
