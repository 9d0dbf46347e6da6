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
  /// Another factor of a pattern that is analysed already.
  explicit SparseCholesky(const SparseCholesky& analysed);
  ~SparseCholesky();
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// Factors A + shift I, of the pattern analysed. Returns false where it is not numerically
  /// positive definite. The factor does not depend on the number of threads.
  [[nodiscard]] bool Factorize(const SymmetricCsc& A, double shift = 0.0, int threads = 1);

  /// A^-1 B. Threads take columns side by side.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& B, int threads = 1) const;

  /// log |A|, of what was factored last.
  double LogDeterminant() const;

  const SupernodalPattern& pattern() const { return multifrontal_->pattern(); }
  const SupernodeTree& tree() const { return multifrontal_->tree(); }
  /// L, as its pattern lays it out.
  const double* values() const { return static_cast<const double*>(factor_->x); }
  /// Row of P A P^T in which unknown i of A stands.
  const std::vector<int>& permuted_index() const { return permuted_index_; }
  long num_nonzeros() const;

 private:
  void Start();
  void SolveColumns(Eigen::Ref<Eigen::MatrixXd> B) const;

  CholmodCommon common_;
  cholmod_factor* factor_ = nullptr;
  std::vector<int> permuted_index_;
  std::shared_ptr<const Multifrontal> multifrontal_;
};

}  // namespace dn
