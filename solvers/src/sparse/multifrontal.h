#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sparse/large_array.h"
#include "sparse/numeric_factor.h"
#include "sparse/supernode_tree.h"

namespace dn::sparse {

/// Numeric Cholesky factorisation by the multifrontal method, for a known supernodal structure.
///
/// A front is the dense lower triangle over the rows of a supernode. It is assembled from the
/// entries of A in the supernode's columns and from the update matrices of its children
/// (extend-add). Its columns are eliminated, and the remaining update matrix U = -L_RJ L_RJ^T plus
/// the children's contributions is passed to the parent.
///
/// Source: Liu (1992), The multifrontal method for sparse matrix solution, SIAM Review 34.
class Multifrontal {
 public:
  /// Prepares the factorisation of matrices with the pattern of A. Unknown i of A is row
  /// permuted_index[i] of L.
  Multifrontal(const SymmetricCsc& A, const std::vector<int>& permuted_index, SupernodalPattern L,
               SupernodeTree tree);

  const SupernodalPattern& pattern() const { return L_; }

  /// Factors A + shift I into `values`, in the layout of L. Returns false if the matrix is not
  /// numerically positive definite. The result does not depend on the number of threads. Throws
  /// std::bad_alloc.
  [[nodiscard]] bool Factorize(const SymmetricCsc& A, double shift, int threads,
                               double* values) const;

 private:
  /// Assembly entry: value `from` of A is added at index `to` of its supernode.
  struct Entry {
    int from = 0;
    int to = 0;
  };

  class Front;
  /// Update matrix U of every supernode, until the parent has assembled it.
  using UpdateMatrices = std::vector<PooledArray>;

  SupernodalPattern L_;
  SupernodeTree tree_;
  /// Entries of supernode s: entries_[first_entry_[s]] .. entries_[first_entry_[s + 1]].
  std::vector<int> first_entry_;
  std::vector<Entry> entries_;
};

/// Numeric factor of the multifrontal method.
class MultifrontalFactor final : public NumericFactor {
 public:
  explicit MultifrontalFactor(std::shared_ptr<const Multifrontal> method)
      : method_(std::move(method)) {}

  bool Factorize(const SymmetricCsc& A, double shift, int threads) override;
  const double* values() const override { return values_.get(); }
  void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> X) const override;
  void SolveForwardInPlace(Eigen::Ref<Eigen::MatrixXd> X) const override;

 private:
  std::shared_ptr<const Multifrontal> method_;
  std::unique_ptr<double[]> values_;
};

}  // namespace dn::sparse
