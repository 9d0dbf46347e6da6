#pragma once

#include <Eigen/Core>

#include "sparse/block_pattern.h"

namespace dn::sparse {

/// Numeric Cholesky factor L of a sparse symmetric matrix in a supernodal layout.
class NumericFactor {
 public:
  NumericFactor() = default;
  virtual ~NumericFactor() = default;
  NumericFactor(const NumericFactor&) = delete;
  NumericFactor& operator=(const NumericFactor&) = delete;

  /// Factors A + shift I. Returns false if it is not numerically positive definite. The result does
  /// not depend on the number of threads. Throws std::bad_alloc.
  [[nodiscard]] virtual bool Factorize(const SymmetricCsc& A, double shift, int threads) = 0;

  /// Returns the values of L.
  virtual const double* values() const = 0;

  /// Computes X (L L^T)^-1 in place. A column of X belongs to one unknown, in the order of L.
  virtual void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> X) const = 0;
  /// Computes the first half, X L^-T, in place.
  virtual void SolveForwardInPlace(Eigen::Ref<Eigen::MatrixXd> X) const = 0;
};

}  // namespace dn::sparse
