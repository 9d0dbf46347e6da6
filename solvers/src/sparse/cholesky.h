#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sparse/block_pattern.h"
#include "sparse/supernode_tree.h"

namespace dn::sparse {

class CholmodFactor;

/// Supernodal Cholesky factorisation A = P^T L L^T P of a sparse symmetric matrix. CHOLMOD
/// analyses, factors and solves in the order that FindEliminationOrder returns.
class Cholesky {
 public:
  /// Orders the blocks (FindEliminationOrder), expands the order to scalar unknowns and analyses
  /// the pattern of A. `layout` gives the sizes of the blocks.
  Cholesky(const SymmetricCsc& A, const SymmetricCsc& blocks, const UnknownLayout& layout);
  /// Shares the analysis of another object but has no numeric factor yet.
  explicit Cholesky(const Cholesky& analysed);
  ~Cholesky();
  Cholesky& operator=(const Cholesky&) = delete;

  /// Factors A + shift I, where A has the analysed pattern. Returns false if it is not numerically
  /// positive definite. Throws std::bad_alloc.
  [[nodiscard]] bool Factorize(const SymmetricCsc& A, double shift = 0.0);

  /// Returns A^-1 B. The columns are distributed over the threads.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& B, int threads = 1) const;

  /// Computes W P A^-1 P^T in place: column permuted_index()[i] of W belongs to unknown i of A.
  void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> W) const;

  /// Applies half of a solution in place: W_B and W_C such that B^T A^-1 C = W_B W_C^T. On entry,
  /// column permuted_index()[i] of W is row i of B, transposed. The rows of W are distributed over
  /// the threads.
  void SolveForward(int threads, Eigen::Ref<Eigen::MatrixXd> W) const;

  /// Returns log |A| of the last factored matrix.
  double LogDeterminant() const;

  /// Returns the square of the smallest diagonal entry of L.
  double SmallestPivot() const;

  const SupernodalPattern& pattern() const;
  const SupernodeTree& tree() const;
  /// Returns the values of L, in the layout of its pattern.
  const double* values() const;
  /// Returns, for each unknown of A, its row in P A P^T.
  const std::vector<int>& permuted_index() const;
  long num_nonzeros() const { return static_cast<long>(pattern().num_values); }

 private:
  struct Analysis;

  /// Computes columns [first, past) of A^-1 B.
  void SolveColumns(const Eigen::MatrixXd& B, Eigen::Index first, Eigen::Index past,
                    Eigen::MatrixXd* X) const;
  /// Returns false also for pivots that are NaN, which LAPACK does not detect.
  bool PivotsArePositive() const;
  /// Calls use(L_ii) for every unknown, in the order of L.
  template <class Use>
  void ForDiagonal(const Use& use) const;

  std::shared_ptr<const Analysis> analysis_;
  std::unique_ptr<CholmodFactor> factor_;
};

}  // namespace dn::sparse
