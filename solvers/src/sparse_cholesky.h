#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "cholmod_support.h"
#include "multifrontal.h"

namespace dn {

/// Supernodal Cholesky factorisation A = P^T L L^T P of a sparse symmetric matrix.
class SparseCholesky {
 public:
  /// Orders the blocks (FindEliminationOrder), expands the order to the scalar unknowns and analyses
  /// the pattern of A. layout gives the sizes of the blocks.
  SparseCholesky(const SymmetricCsc& A, const SymmetricCsc& blocks, const UnknownLayout& layout);
  /// Another factor of a pattern that is analysed already, still without numbers.
  explicit SparseCholesky(const SparseCholesky& analysed) : analysis_(analysed.analysis_) {}
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// Factors A + shift I, of the pattern analysed. Returns false where it is not numerically
  /// positive definite. The factor does not depend on the number of threads.
  [[nodiscard]] bool Factorize(const SymmetricCsc& A, double shift = 0.0, int threads = 1);

  /// A^-1 B. Threads take columns side by side.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& B, int threads = 1) const;

  /// Half of a solution: B^T A^-1 C = W_B W_C^T. On entry column permuted_index()[i] of W is row i of
  /// B, transposed. Threads take rows of W side by side.
  void SolveForward(int threads, Eigen::Ref<Eigen::MatrixXd> W) const;

  /// log |A|, of what was factored last.
  double LogDeterminant() const;

  /// The square of the smallest diagonal entry of L.
  double LeastPivot() const;

  const SupernodalPattern& pattern() const { return analysis_->numbers.pattern(); }
  const SupernodeTree& tree() const { return analysis_->numbers.tree(); }
  /// L, as its pattern lays it out.
  const double* values() const { return values_.get(); }
  /// Row of P A P^T in which unknown i of A stands.
  const std::vector<int>& permuted_index() const { return analysis_->permuted_index; }
  long num_nonzeros() const { return static_cast<long>(pattern().num_values); }

 private:
  /// What depends on the pattern alone.
  struct Analysis {
    std::vector<int> permuted_index;
    Multifrontal numbers;

    Analysis(const SymmetricCsc& A, const cholmod_factor& analysed);
  };

  void SolveColumns(const Eigen::Ref<const Eigen::MatrixXd>& B,
                    Eigen::Ref<Eigen::MatrixXd> X) const;
  /// Calls use(L_ii) for every unknown, in the order of L.
  template <class Use>
  void ForDiagonal(const Use& use) const;

  std::shared_ptr<const Analysis> analysis_;
  std::unique_ptr<double[]> values_;
};

}  // namespace dn
