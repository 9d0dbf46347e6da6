#pragma once

#include <Eigen/Core>

#include "sparse/cholmod_support.h"

namespace dn::sparse {

/// Numeric factor L of P A P^T, computed by CHOLMOD in its supernodal layout.
class CholmodFactor {
 public:
  /// Copies the supernodal analysis of a pattern.
  explicit CholmodFactor(const cholmod_factor& analysed);

  /// Factors A + shift I. Returns false if CHOLMOD finds a pivot that is not positive.
  [[nodiscard]] bool Factorize(const SymmetricCsc& A, double shift);

  /// Returns the values of L.
  const double* values() const { return static_cast<const double*>(L_->x); }

  /// Computes (L L^T)^-1 X in place; the rows of X are in the order of L.
  void Solve(Eigen::MatrixXd* X) const;
  /// Computes L^-1 X in place.
  void SolveForward(Eigen::MatrixXd* X) const;

 private:
  CholmodCommon common_;
  CholmodFactorPointer L_;
};

}  // namespace dn::sparse
