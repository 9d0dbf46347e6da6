#pragma once

#include <memory>

#include "sparse/cholmod_support.h"
#include "sparse/numeric_factor.h"

namespace dn::sparse {

/// Numeric factor that CHOLMOD computes and solves with, in its supernodal layout.
class CholmodFactor final : public NumericFactor {
 public:
  /// Copies the supernodal analysis of a pattern.
  explicit CholmodFactor(const cholmod_factor& analysed);

  bool Factorize(const SymmetricCsc& A, double shift, int threads) override;
  const double* values() const override { return static_cast<const double*>(L_->x); }
  void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> X) const override;
  void SolveForwardInPlace(Eigen::Ref<Eigen::MatrixXd> X) const override;

 private:
  template <class Halves>
  void SolveTransposed(Eigen::Ref<Eigen::MatrixXd> X, const Halves& halves) const;

  CholmodCommon common_;
  CholmodFactorPointer L_;
};

}  // namespace dn::sparse
