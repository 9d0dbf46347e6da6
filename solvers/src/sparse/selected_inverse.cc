#include "sparse/selected_inverse.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "sparse/blas.h"
#include "sparse/large_array.h"
#include "sparse/parallel_for.h"

namespace dn::sparse {
/// Computes the entries of one supernode.
class SelectedInverse::Step {
 public:
  Step(SelectedInverse* inverse, ArrayPool* pool, int s)
      : self_(*inverse),
        pool_(*pool),
        L_(self_.cholesky_.pattern()),
        s_(s),
        columns_(L_.columns(s)),
        rows_(L_.rows(s)),
        below_(L_.below(s)) {}

  void Run(int threads) {
    InvertDiagonal(threads);
    if (below_ > 0) {
      const PooledArray Z_RR = Gather(threads), Y = Multipliers(threads);
      ForPanels(columns_, threads,
                [&](int first, int n) { InvertPanel(first, n, Z_RR.get(), Y.get()); });
    }
    MirrorDiagonal();
  }

 private:
  const double* L(int column) const {
    return self_.cholesky_.values() + L_.value_start[AsSize(s_)] + AsSize(column) * AsSize(rows_);
  }
  double* Z(int column) const { return self_.Z(s_) + AsSize(column) * AsSize(rows_); }

  /// Computes the lower triangle of L_JJ^-T L_JJ^-1.
  void InvertDiagonal(int threads) const {
    const PooledArray inverse = pool_.New(AsSize(columns_) * AsSize(columns_));
    const auto column = [&](int c) { return inverse.get() + AsSize(c) * AsSize(columns_); };
    for (int c = 0; c < columns_; ++c) {
      std::fill_n(column(c), c, 0.0);
      std::copy_n(L(c) + c, columns_ - c, column(c) + c);
    }
    int info = 0;
    dtrtri_("L", "N", &columns_, inverse.get(), &columns_, &info);
    ForPanels(columns_, threads, [&](int first, int n) {
      const int m = columns_ - first;
      for (int c = first; c < first + n; ++c) std::copy_n(column(c) + first, m, Z(c) + first);
      dtrmm_("L", "L", "T", "N", &m, &n, &kOne, column(first) + first, &columns_, Z(first) + first,
             &rows_);
    });
  }

  /// Returns Y = L_RJ L_JJ^-1.
  PooledArray Multipliers(int threads) const {
    PooledArray Y = pool_.New(AsSize(below_) * AsSize(columns_));
    ForPanels(below_, threads, [&](int first, int n) {
      for (int c = 0; c < columns_; ++c) {
        std::copy_n(L(c) + columns_ + first, n, Y.get() + AsSize(c) * AsSize(below_) + first);
      }
      dtrsm_("R", "L", "N", "N", &n, &columns_, &kOne, L(0), &rows_, Y.get() + first, &below_);
    });
    return Y;
  }

  /// Computes n columns of Z_RJ, and subtracts Y^T Z_RJ from the lower triangle of Z_JJ.
  void InvertPanel(int first, int n, const double* Z_RR, const double* Y) const {
    const double* Y_of_panel = Y + AsSize(first) * AsSize(below_);
    double* Z_below = Z(first) + columns_;
    dsymm_("L", "L", &below_, &n, &kMinusOne, Z_RR, &below_, Y_of_panel, &below_, &kZero, Z_below,
           &rows_);
    const int m = columns_ - first;
    dgemm_("T", "N", &m, &n, &below_, &kMinusOne, Y_of_panel, &below_, Z_below, &rows_, &kOne,
           Z(first) + first, &rows_);
  }

  void MirrorDiagonal() const {
    for (int c = 0; c < columns_; ++c) {
      for (int r = c + 1; r < columns_; ++r) Z(r)[c] = Z(c)[r];
    }
  }

  /// Gathers the lower triangle of Z_RR from the supernodes that own the columns R.
  PooledArray Gather(int threads) const {
    PooledArray Z_RR = pool_.New(AsSize(below_) * AsSize(below_));
    const int* R = L_.row_indices_below(s_);
    std::vector<int> first_of_owner;
    for (int i = 0; i < below_; ++i) {
      const bool same = i > 0 && Owner(R[i]) == Owner(R[i - 1]);
      if (!same) first_of_owner.push_back(i);
    }
    const auto owners = static_cast<int>(first_of_owner.size());
    ParallelForDynamic(owners, below_ < kPanelSize ? 1 : threads, [&](int k) {
      const int past = k + 1 < owners ? first_of_owner[AsSize(k + 1)] : below_;
      GatherFrom(Owner(R[first_of_owner[AsSize(k)]]), first_of_owner[AsSize(k)], past, Z_RR.get());
    });
    return Z_RR;
  }

  int Owner(int column) const { return self_.cholesky_.tree().column_owner(column); }

  /// Copies columns first .. past of Z_RR, which belong to one supernode.
  void GatherFrom(int owner, int first, int past, double* Z_RR) const {
    const int* R = L_.row_indices_below(s_);
    const int* rows = L_.row_indices(owner);
    std::vector<int> place(AsSize(below_ - first));
    int k = 0;
    for (int i = first; i < below_; ++i) {
      while (rows[k] != R[i]) ++k;
      place[AsSize(i - first)] = k;
    }
    for (int c = first; c < past; ++c) {
      const double* from =
          self_.Z(owner) + AsSize(R[c] - L_.column[AsSize(owner)]) * AsSize(L_.rows(owner));
      double* to = Z_RR + AsSize(c) * AsSize(below_);
      for (int i = c; i < below_; ++i) to[i] = from[place[AsSize(i - first)]];
    }
  }

  SelectedInverse& self_;
  ArrayPool& pool_;
  const SupernodalPattern& L_;
  int s_, columns_, rows_, below_;
};

SelectedInverse::SelectedInverse(const Cholesky& cholesky, int threads)
    : cholesky_(cholesky), value_(NewArray(cholesky.pattern().num_values)) {
  constexpr int kArraysPerStep = 3;
  ArrayPool pool(kArraysPerStep * threads);
  cholesky.tree().Down(threads,
                       [&](int s, int threads_here) { Step(this, &pool, s).Run(threads_here); });
}

double* SelectedInverse::Z(int s) {
  return value_.get() + cholesky_.pattern().value_start[AsSize(s)];
}

std::optional<double> SelectedInverse::At(int i, int j) const {
  const SupernodalPattern& L = cholesky_.pattern();
  const int row = std::max(i, j), column = std::min(i, j);
  const int s = cholesky_.tree().column_owner(column);
  const int* begin = L.row_indices(s);
  const int* end = begin + L.rows(s);
  const int* found = std::lower_bound(begin, end, row);
  if (found == end || *found != row) return std::nullopt;
  return ColumnData(s, column)[found - begin];
}

const double* SelectedInverse::ColumnData(int s, int column) const {
  const SupernodalPattern& L = cholesky_.pattern();
  return value_.get() + L.value_start[AsSize(s)] +
         AsSize(column - L.column[AsSize(s)]) * AsSize(L.rows(s));
}

bool SelectedInverse::Gather(const std::vector<int>& indices, Eigen::MatrixXd* Z) const {
  const SupernodalPattern& L = cholesky_.pattern();
  const std::size_t n = indices.size();
  std::vector<std::size_t> by_index(n);
  std::iota(by_index.begin(), by_index.end(), std::size_t{0});
  std::sort(by_index.begin(), by_index.end(),
            [&](std::size_t a, std::size_t b) { return indices[a] < indices[b]; });
  // Position of each index among the rows of the current supernode.
  std::vector<std::ptrdiff_t> place(n);
  int owner = -1;
  Z->resize(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  for (std::size_t c = 0; c < n; ++c) {
    const int column = indices[by_index[c]];
    if (const int s = cholesky_.tree().column_owner(column); s != owner) {
      owner = s;
      const int* const begin = L.row_indices(s);
      const int* const end = begin + L.rows(s);
      const int* at = begin;
      for (std::size_t r = c; r < n; ++r) {
        at = std::lower_bound(at, end, indices[by_index[r]]);
        if (at == end || *at != indices[by_index[r]]) return false;
        place[r] = at - begin;
      }
    }
    const double* const values = ColumnData(owner, column);
    const auto j = static_cast<Eigen::Index>(by_index[c]);
    for (std::size_t r = c; r < n; ++r) {
      const auto i = static_cast<Eigen::Index>(by_index[r]);
      (*Z)(i, j) = (*Z)(j, i) = values[place[r]];
    }
  }
  return true;
}

}  // namespace dn::sparse
