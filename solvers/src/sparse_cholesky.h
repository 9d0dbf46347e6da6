#pragma once

#include <Eigen/Core>
#include <vector>

#include "cholmod_support.h"

namespace dn {

/// The factor of a SparseCholesky by supernodes: P A P^T = L L^T. Supernode s has the columns
/// column[s] .. column[s + 1] and the rows row[row_start[s]] .. row[row_start[s + 1]], of which the
/// first are its columns; its values are dense, column-major, from value_start[s].
struct SupernodalView {
  int num_supernodes = 0;
  const int* column = nullptr;
  const int* row_start = nullptr;
  const int* value_start = nullptr;
  const int* row = nullptr;
  const double* value = nullptr;
  std::size_t num_values = 0;
};

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
  /// positive definite.
  [[nodiscard]] bool Factorize(const SymmetricCsc& A, double shift = 0.0);

  /// A^-1 B. Threads take columns side by side.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& B, int threads = 1) const;

  /// log |A|, of what was factored last.
  double LogDeterminant() const;

  SupernodalView view() const;
  /// Row of P A P^T in which unknown i of A stands.
  const std::vector<int>& permuted_index() const { return permuted_index_; }
  long num_nonzeros() const;

 private:
  void Start();
  void SolveColumns(Eigen::Ref<Eigen::MatrixXd> B) const;

  CholmodCommon common_;
  cholmod_factor* factor_ = nullptr;
  std::vector<int> permuted_index_;
};

}  // namespace dn
