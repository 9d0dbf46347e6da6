#pragma once

#include <memory>
#include <vector>

#include "block_pattern.h"
#include "large_array.h"
#include "supernode_tree.h"

namespace dn {

/// The numbers of a Cholesky factor whose supernodes are known, front by front.
///
/// A front is the dense lower triangle over the rows of a supernode: the entries of A in its
/// columns, and what its children leave. Its columns are eliminated, and what that leaves below
/// them, U = -L_RJ L_RJ^T and what the children left there, goes to the parent.
///
/// Source: Liu (1992), The multifrontal method for sparse matrix solution, SIAM Review 34.
class Multifrontal {
 public:
  /// For matrices of the pattern of A; unknown i of it is row permuted_index[i] of L.
  Multifrontal(const SymmetricCsc& A, const std::vector<int>& permuted_index, SupernodalPattern L);

  const SupernodalPattern& pattern() const { return L_; }
  const SupernodeTree& tree() const { return tree_; }

  /// Factors A + shift I into `values`, as L lays them out. Returns false where that is not
  /// numerically positive definite. The numbers do not depend on the number of threads. Throws
  /// std::bad_alloc.
  [[nodiscard]] bool Factorize(const SymmetricCsc& A, double shift, int threads,
                               double* values) const;

 private:
  /// Value `from` of A goes to entry `to` of its supernode.
  struct Entry {
    int from = 0;
    int to = 0;
  };

  class Front;
  /// Of every supernode what it leaves to its parent, U, until that has taken it.
  using Left = std::vector<PooledArray>;

  SupernodalPattern L_;
  SupernodeTree tree_;
  std::vector<int> first_entry_;  ///< of supernode s: entries_[first_entry_[s]] .. [s + 1]
  std::vector<Entry> entries_;
};

}  // namespace dn
