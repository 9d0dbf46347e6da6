#include "sparse/multifrontal.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

#include "sparse/blas.h"
#include "sparse/parallel_for.h"
#include "sparse/triangular_solve.h"

namespace dn::sparse {
/// A run of consecutive source entries whose targets are also consecutive. A member of Multifrontal
/// has this type, so it is not in an unnamed namespace.
struct EntryRun {
  int from = 0;
  int to = 0;
  int length = 0;
};

namespace {

/// Returns the index of each of `rows` within `among`, which contains them; both are ascending.
std::vector<int> Places(const int* rows, int num_rows, const int* among) {
  std::vector<int> place(AsSize(num_rows));
  int k = 0;
  for (int i = 0; i < num_rows; ++i) {
    while (among[k] != rows[i]) ++k;
    place[AsSize(i)] = k;
  }
  return place;
}

std::vector<EntryRun> Runs(const std::vector<int>& place) {
  std::vector<EntryRun> runs;
  for (int i = 0; i < static_cast<int>(place.size()); ++i) {
    const int to = place[AsSize(i)];
    if (!runs.empty() && runs.back().to + runs.back().length == to) {
      ++runs.back().length;
    } else {
      runs.push_back({i, to, 1});
    }
  }
  return runs;
}

/// Finds the index of a row within a supernode. Most rows follow the previous one, so that case is
/// tested first.
class RowFinder {
 public:
  explicit RowFinder(const SupernodalPattern& L) : L_(L) {}

  int At(int s, int row) {
    const int* rows = L_.row_indices(s);
    const int count = L_.rows(s);
    if (s != s_ || !Follows(rows, count, row)) {
      at_ = static_cast<int>(std::lower_bound(rows, rows + count, row) - rows);
    }
    s_ = s;
    return at_;
  }

 private:
  bool Follows(const int* rows, int count, int row) {
    if (rows[at_] != row) ++at_;
    return at_ < count && rows[at_] == row;
  }

  const SupernodalPattern& L_;
  int s_ = -1, at_ = 0;
};

double* Column(double* matrix, int column, int rows) {
  return matrix + AsSize(column) * AsSize(rows);
}

}  // namespace

/// The front of one supernode.
class Multifrontal::Front {
 public:
  Front(const Multifrontal& all, int s, double* values, ArrayPool* pool, UpdateMatrices* updates)
      : all_(all),
        pool_(*pool),
        updates_(*updates),
        s_(s),
        columns_(all.L_.columns(s)),
        rows_(all.L_.rows(s)),
        below_(all.L_.below(s)),
        F_(values + all.L_.value_start[AsSize(s)]) {}

  void AddEntries(const SymmetricCsc& A, double shift) {
    std::fill_n(F_, AsSize(rows_) * AsSize(columns_), 0.0);
    for (int e = all_.first_entry_[AsSize(s_)]; e < all_.first_entry_[AsSize(s_) + 1]; ++e) {
      const Entry& entry = all_.entries_[AsSize(e)];
      F_[entry.to] = A.value[AsSize(entry.from)];
    }
    for (int c = 0; c < columns_; ++c) Column(F_, c, rows_)[c] += shift;
  }

  /// Adds the columns of the children's update matrices that belong to the columns of this front.
  void ExtendAddColumns() {
    for (const int child : all_.tree_.children(s_)) {
      const Child from(all_.L_, child, s_, updates_);
      for (int j = 0; j < from.size && from.place[AsSize(j)] < columns_; ++j) {
        from.Add(j, 0, Column(F_, from.place[AsSize(j)], rows_));
      }
    }
  }

  /// Eliminates the columns. Returns false if the front is not positive definite.
  bool Eliminate(int threads) {
    for (int k = 0; k < columns_; k += kPanelSize) {
      const int n = std::min(kPanelSize, columns_ - k);
      if (!EliminatePanel(k, n, threads)) return false;
    }
    return true;
  }

  void ComputeUpdateMatrix(int threads) {
    if (below_ == 0) return;
    PooledArray& U = updates_[AsSize(s_)];
    U = pool_.New(AsSize(below_) * AsSize(below_));
    ForPanels(below_, threads, [&](int first, int n) {
      Update(columns_ + first, n, 0, columns_, kZero, Column(U.get(), first, below_) + first,
             below_);
    });
  }

  /// Adds the remaining columns of the children's update matrices to this update matrix, and frees
  /// them.
  void ExtendAddRest() {
    for (const int child : all_.tree_.children(s_)) {
      const Child from(all_.L_, child, s_, updates_);
      for (int j = 0; j < from.size; ++j) {
        const int column = from.place[AsSize(j)] - columns_;
        if (column < 0) continue;
        from.Add(j, columns_, Column(updates_[AsSize(s_)].get(), column, below_));
      }
      updates_[AsSize(child)].reset();
    }
  }

 private:
  /// Update matrix of a child, with the positions of its rows in the front of the parent.
  struct Child {
    Child(const SupernodalPattern& L, int child, int parent, const UpdateMatrices& updates)
        : size(L.below(child)),
          U(updates[AsSize(child)].get()),
          place(Places(L.row_indices_below(child), size, L.row_indices(parent))),
          runs(Runs(place)) {}

    /// Adds column j, from its diagonal downwards, to a column whose first entry is row first_row.
    void Add(int j, int first_row, double* column) const {
      const double* from = U + AsSize(j) * AsSize(size);
      for (const EntryRun& run : runs) {
        const int skip = std::max(0, j - run.from);
        for (int i = skip; i < run.length; ++i) {
          column[run.to - first_row + i] += from[run.from + i];
        }
      }
    }

    int size;
    const double* U;
    std::vector<int> place;
    std::vector<EntryRun> runs;
  };

  bool EliminatePanel(int k, int n, int threads) {
    double* diagonal = Column(F_, k, rows_) + k;
    int info = 0;
    dpotrf_("L", &n, diagonal, &rows_, &info);
    if (info != 0) return false;
    for (int c = 0; c < n; ++c) {  // LAPACK does not detect NaN pivots
      if (!(Column(diagonal, c, rows_)[c] > 0.0)) return false;
    }
    const int first = k + n, rest = rows_ - first;
    if (rest == 0) return true;
    ForPanels(rest, threads, [&](int row, int m) {
      dtrsm_("R", "L", "T", "N", &m, &n, &kOne, diagonal, &rows_,
             Column(F_, k, rows_) + first + row, &rows_);
    });
    ForPanels(columns_ - first, threads, [&](int column, int width) {
      const int c = first + column;
      Update(c, width, k, n, kOne, Column(F_, c, rows_) + c, rows_);
    });
    return true;
  }

  /// Computes to = beta to - F_R F_C^T, lower part, over the n columns from k on. C are the `width`
  /// rows from `first` on; R are those rows and all rows below.
  void Update(int first, int width, int k, int n, double beta, double* to, int stride) const {
    const double* at = F_ + AsSize(k) * AsSize(rows_) + first;
    dsyrk_("L", "N", &width, &n, &kMinusOne, at, &rows_, &beta, to, &stride);
    const int under = rows_ - first - width;
    if (under == 0) return;
    dgemm_("N", "T", &under, &width, &n, &kMinusOne, at + width, &rows_, at, &rows_, &beta,
           to + width, &stride);
  }

  const Multifrontal& all_;
  ArrayPool& pool_;
  UpdateMatrices& updates_;
  int s_, columns_, rows_, below_;
  double* F_;
};

Multifrontal::Multifrontal(const SymmetricCsc& A, const std::vector<int>& permuted_index,
                           SupernodalPattern L, SupernodeTree tree)
    : L_(std::move(L)),
      tree_(std::move(tree)),
      first_entry_(AsSize(L_.num_supernodes()) + 1, 0),
      entries_(A.row.size()) {
  const auto for_all = [&](const auto& use) {
    for (int j = 0; j < A.n; ++j) {
      for (int e = A.column_start[AsSize(j)]; e < A.column_start[AsSize(j) + 1]; ++e) {
        const int r = permuted_index[AsSize(A.row[AsSize(e)])], c = permuted_index[AsSize(j)];
        use(e, std::max(r, c), std::min(r, c), tree_.column_owner(std::min(r, c)));
      }
    }
  };
  for_all([&](int, int, int, int s) { ++first_entry_[AsSize(s) + 1]; });
  std::partial_sum(first_entry_.begin(), first_entry_.end(), first_entry_.begin());
  std::vector<int> next(first_entry_.begin(), first_entry_.end() - 1);
  RowFinder finder(L_);
  for_all([&](int e, int row, int column, int s) {
    const int at = finder.At(s, row);
    entries_[AsSize(next[AsSize(s)]++)] = {e, (column - L_.column[AsSize(s)]) * L_.rows(s) + at};
  });
}

bool Multifrontal::Factorize(const SymmetricCsc& A, double shift, int threads,
                             double* values) const {
  ArrayPool pool(threads);
  UpdateMatrices updates(AsSize(L_.num_supernodes()));
  std::atomic<bool> definite{true};
  tree_.Up(threads, [&](int s, int threads_here) {
    if (!definite) return;
    Front front(*this, s, values, &pool, &updates);
    front.AddEntries(A, shift);
    front.ExtendAddColumns();
    if (!front.Eliminate(threads_here)) {
      definite = false;
      return;
    }
    front.ComputeUpdateMatrix(threads_here);
    front.ExtendAddRest();
  });
  return definite;
}

bool MultifrontalFactor::Factorize(const SymmetricCsc& A, double shift, int threads) {
  if (!values_) values_ = NewArray(method_->pattern().num_values);
  return method_->Factorize(A, shift, threads, values_.get());
}

void MultifrontalFactor::SolveInPlace(Eigen::Ref<Eigen::MatrixXd> X) const {
  SolveBothWays(method_->pattern(), values_.get(), static_cast<int>(X.rows()),
                static_cast<int>(X.outerStride()), X.data());
}

void MultifrontalFactor::SolveForwardInPlace(Eigen::Ref<Eigen::MatrixXd> X) const {
  SolveForwards(method_->pattern(), values_.get(), static_cast<int>(X.rows()),
                static_cast<int>(X.outerStride()), X.data());
}

}  // namespace dn::sparse
