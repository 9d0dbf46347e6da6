#include "selected_inverse.h"

#include <algorithm>

extern "C" {
void dsymm_(const char* side, const char* uplo, const int* m, const int* n, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta,
            double* c, const int* ldc);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
            const double* beta, double* c, const int* ldc);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
}

namespace dn {
namespace {

constexpr double kOne = 1.0;
constexpr double kMinusOne = -1.0;
constexpr double kZero = 0.0;

}  // namespace

/// One pass over the supernodes with its work space.
class SelectedInverse::Recursion {
 public:
  explicit Recursion(SelectedInverse* inverse) : self_(*inverse), L_(inverse->L_) {
    std::size_t largest_R = 0, largest_RJ = 0;
    for (int s = 0; s < L_.num_supernodes; ++s) {
      const std::size_t below = static_cast<std::size_t>(Rows(s) - Columns(s));
      largest_R = std::max(largest_R, below);
      largest_RJ = std::max(largest_RJ, below * static_cast<std::size_t>(Columns(s)));
    }
    Z_RR_.resize(largest_R * largest_R);
    Y_.resize(largest_RJ);
    place_.resize(largest_R);
  }

  void Run() {
    for (int s = L_.num_supernodes - 1; s >= 0; --s) Step(s);
  }

 private:
  int Columns(int s) const { return L_.column[s + 1] - L_.column[s]; }
  int Rows(int s) const { return L_.row_start[s + 1] - L_.row_start[s]; }
  double* Z(int s) { return self_.value_.data() + L_.value_start[s]; }

  void Step(int s) {
    const int columns = Columns(s), rows = Rows(s), below = rows - columns;
    const double* L_JJ = L_.value + L_.value_start[s];
    double* Z_JJ = Z(s);
    double* Z_RJ = Z_JJ + columns;
    InvertDiagonal(L_JJ, columns, rows, Z_JJ);
    if (below > 0) {
      for (int c = 0; c < columns; ++c) {
        const double* from = L_JJ + static_cast<std::size_t>(c) * static_cast<std::size_t>(rows);
        std::copy_n(from + columns, below, Y_.begin() + static_cast<std::ptrdiff_t>(c) * below);
      }
      dtrsm_("R", "L", "N", "N", &below, &columns, &kOne, L_JJ, &rows, Y_.data(), &below);
      Gather(s, below);
      dsymm_("L", "L", &below, &columns, &kMinusOne, Z_RR_.data(), &below, Y_.data(), &below,
             &kZero, Z_RJ, &rows);
      dgemm_("T", "N", &columns, &columns, &below, &kMinusOne, Y_.data(), &below, Z_RJ, &rows,
             &kOne, Z_JJ, &rows);
    }
    Symmetrize(columns, rows, Z_JJ);
  }

  /// Z_JJ = L_JJ^-T L_JJ^-1.
  static void InvertDiagonal(const double* L_JJ, int columns, int rows, double* Z_JJ) {
    for (int c = 0; c < columns; ++c) {
      double* column = Z_JJ + static_cast<std::size_t>(c) * static_cast<std::size_t>(rows);
      std::fill_n(column, columns, 0.0);
      column[c] = 1.0;
    }
    dtrsm_("L", "L", "N", "N", &columns, &columns, &kOne, L_JJ, &rows, Z_JJ, &rows);
    dtrsm_("L", "L", "T", "N", &columns, &columns, &kOne, L_JJ, &rows, Z_JJ, &rows);
  }

  /// Both triangles of Z_JJ become their mean.
  static void Symmetrize(int columns, int rows, double* Z_JJ) {
    const auto stride = static_cast<std::size_t>(rows);
    for (std::size_t c = 0; c < static_cast<std::size_t>(columns); ++c) {
      for (std::size_t r = c + 1; r < static_cast<std::size_t>(columns); ++r) {
        const double mean = 0.5 * (Z_JJ[c * stride + r] + Z_JJ[r * stride + c]);
        Z_JJ[c * stride + r] = Z_JJ[r * stride + c] = mean;
      }
    }
  }

  /// The lower triangle of Z_RR, from the supernodes that own the columns R.
  void Gather(int s, int below) {
    const int* R = L_.row + L_.row_start[s] + Columns(s);
    for (int first = 0; first < below;) {
      const int owner = self_.supernode_of_column_[static_cast<std::size_t>(R[first])];
      LocateRows(R, first, below, owner);
      for (; first < below && R[first] < L_.column[owner + 1]; ++first) {
        const double* from = Z(owner) + static_cast<std::size_t>(R[first] - L_.column[owner]) *
                                            static_cast<std::size_t>(Rows(owner));
        double* to =
            Z_RR_.data() + static_cast<std::size_t>(first) * static_cast<std::size_t>(below);
        for (int i = first; i < below; ++i) to[i] = from[place_[static_cast<std::size_t>(i)]];
      }
    }
  }

  /// place_[i]: where R[i] stands among the rows of the owner, which contain them.
  void LocateRows(const int* R, int first, int below, int owner) {
    const int* rows = L_.row + L_.row_start[owner];
    int k = 0;
    for (int i = first; i < below; ++i) {
      while (rows[k] != R[i]) ++k;
      place_[static_cast<std::size_t>(i)] = k;
    }
  }

  SelectedInverse& self_;
  const SupernodalView& L_;
  std::vector<double> Z_RR_, Y_;
  std::vector<int> place_;
};

SelectedInverse::SelectedInverse(const SparseCholesky& cholesky)
    : L_(cholesky.view()), value_(L_.num_values) {
  supernode_of_column_.resize(static_cast<std::size_t>(L_.column[L_.num_supernodes]));
  for (int s = 0; s < L_.num_supernodes; ++s) {
    std::fill(supernode_of_column_.begin() + L_.column[s],
              supernode_of_column_.begin() + L_.column[s + 1], s);
  }
  Recursion(this).Run();
}

std::optional<double> SelectedInverse::At(int i, int j) const {
  const int row = std::max(i, j), column = std::min(i, j);
  const int s = supernode_of_column_[static_cast<std::size_t>(column)];
  const int* begin = L_.row + L_.row_start[s];
  const int* end = L_.row + L_.row_start[s + 1];
  const int* found = std::lower_bound(begin, end, row);
  if (found == end || *found != row) return std::nullopt;
  const auto rows = static_cast<std::size_t>(end - begin);
  return value_[static_cast<std::size_t>(L_.value_start[s]) +
                static_cast<std::size_t>(column - L_.column[s]) * rows +
                static_cast<std::size_t>(found - begin)];
}

}  // namespace dn
