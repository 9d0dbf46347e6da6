#include "sparse/triangular_solve.h"

#include <algorithm>
#include <vector>

#include "linearization.h"
#include "sparse/blas.h"

namespace dn::sparse {
namespace {

/// Forward and backward substitution over the supernodes.
class Substitution {
 public:
  Substitution(const SupernodalPattern& L, const double* values, int k, int stride, double* X)
      : L_(L), values_(values), k_(k), stride_(stride), X_(X) {
    int largest = 0;
    for (int s = 0; s < L.num_supernodes(); ++s) largest = std::max(largest, L.below(s));
    below_.resize(AsSize(largest) * AsSize(k));
  }

  /// Computes X_J = X_J L_JJ^-T, X_R -= X_J L_RJ^T.
  void Forward(int s) {
    const int columns = L_.columns(s), rows = L_.rows(s), below = L_.below(s);
    const double* L_JJ = values_ + L_.value_start[AsSize(s)];
    double* X_J = Column(L_.column[AsSize(s)]);
    dtrsm_("R", "L", "T", "N", &k_, &columns, &kOne, L_JJ, &rows, X_J, &stride_);
    if (below == 0) return;
    dgemm_("N", "T", &k_, &below, &columns, &kOne, X_J, &stride_, L_JJ + columns, &rows, &kZero,
           below_.data(), &k_);
    const int* R = L_.row_indices_below(s);
    for (int i = 0; i < below; ++i) {
      double* to = Column(R[i]);
      const double* from = below_.data() + AsSize(i) * AsSize(k_);
      for (int c = 0; c < k_; ++c) to[c] -= from[c];
    }
  }

  /// Computes X_J = (X_J - X_R L_RJ) L_JJ^-1.
  void Backward(int s) {
    const int columns = L_.columns(s), rows = L_.rows(s), below = L_.below(s);
    const double* L_JJ = values_ + L_.value_start[AsSize(s)];
    double* X_J = Column(L_.column[AsSize(s)]);
    if (below > 0) {
      const int* R = L_.row_indices_below(s);
      for (int i = 0; i < below; ++i) {
        std::copy_n(Column(R[i]), k_, below_.begin() + static_cast<std::ptrdiff_t>(i) * k_);
      }
      dgemm_("N", "N", &k_, &columns, &below, &kMinusOne, below_.data(), &k_, L_JJ + columns, &rows,
             &kOne, X_J, &stride_);
    }
    dtrsm_("R", "L", "N", "N", &k_, &columns, &kOne, L_JJ, &rows, X_J, &stride_);
  }

 private:
  double* Column(int row) { return X_ + AsSize(row) * AsSize(stride_); }

  const SupernodalPattern& L_;
  const double* values_;
  int k_, stride_;
  double* X_;
  std::vector<double> below_;
};

}  // namespace

void SolveBothWays(const SupernodalPattern& L, const double* values, int k, int stride, double* X) {
  Substitution substitution(L, values, k, stride, X);
  for (int s = 0; s < L.num_supernodes(); ++s) substitution.Forward(s);
  for (int s = L.num_supernodes() - 1; s >= 0; --s) substitution.Backward(s);
}

void SolveForwards(const SupernodalPattern& L, const double* values, int k, int stride, double* X) {
  Substitution substitution(L, values, k, stride, X);
  for (int s = 0; s < L.num_supernodes(); ++s) substitution.Forward(s);
}

}  // namespace dn::sparse
