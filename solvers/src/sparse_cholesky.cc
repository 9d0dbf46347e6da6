#include "sparse_cholesky.h"

#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <string>

#include "elimination_order.h"
#include "large_array.h"
#include "serial_blas.h"
#include "triangular_solve.h"

namespace dn {
namespace {

std::vector<int> ExpandOrder(const std::vector<int>& block_order, const UnknownLayout& layout) {
  std::vector<int> order;
  order.reserve(static_cast<std::size_t>(layout.size()));
  for (const int position : block_order) {
    for (int k = 0; k < layout.block_size(position); ++k) {
      order.push_back(layout.offset[static_cast<std::size_t>(position)] + k);
    }
  }
  return order;
}

SupernodalPattern CopyPattern(const cholmod_factor& factor) {
  const auto copy = [](const void* ints, std::size_t size) {
    const int* first = static_cast<const int*>(ints);
    return std::vector<int>(first, first + size);
  };
  SupernodalPattern pattern;
  pattern.column = copy(factor.super, factor.nsuper + 1);
  pattern.row_start = copy(factor.pi, factor.nsuper + 1);
  pattern.value_start = copy(factor.px, factor.nsuper);
  pattern.row = copy(factor.s, AsSize(pattern.row_start.back()));
  pattern.num_values = factor.xsize;
  return pattern;
}

std::vector<int> Inverse(const int* permutation, int n) {
  std::vector<int> inverse(AsSize(n));
  for (int i = 0; i < n; ++i) inverse[AsSize(permutation[i])] = i;
  return inverse;
}

/// Minimum number of right-hand sides per thread.
constexpr int kFewestColumns = 8;
/// Maximum number of right-hand sides solved together.
constexpr int kMostColumns = 16;

}  // namespace

SparseCholesky::Analysis::Analysis(const SymmetricCsc& A, const cholmod_factor& analysed)
    : permuted_index(Inverse(static_cast<const int*>(analysed.Perm), A.n)),
      numbers(A, permuted_index, CopyPattern(analysed)) {}

SparseCholesky::SparseCholesky(const SymmetricCsc& A, const SymmetricCsc& blocks,
                               const UnknownLayout& layout) {
  CholmodCommon common;
  common->nmethods = 1;
  common->method[0].ordering = CHOLMOD_GIVEN;
  common->supernodal = CHOLMOD_SUPERNODAL;
  const EliminationOrder elimination = FindEliminationOrder(blocks, layout.size());
  std::vector<int> order = ExpandOrder(elimination.position, layout);
  cholmod_sparse view = View(A);
  const auto free = [&](cholmod_factor* factor) { cholmod_free_factor(&factor, common.get()); };
  const std::unique_ptr<cholmod_factor, decltype(free)> factor(
      cholmod_analyze_p(&view, order.data(), nullptr, 0, common.get()), free);
  common.Check("analysing");
  analysis_ = std::make_shared<const Analysis>(A, *factor);
}

bool SparseCholesky::Factorize(const SymmetricCsc& A, double shift, int threads) {
  if (!values_) values_ = NewArray(pattern().num_values);
  return analysis_->numbers.Factorize(A, shift, threads, values_.get());
}

Eigen::MatrixXd SparseCholesky::Solve(const Eigen::MatrixXd& B, int threads) const {
  Eigen::MatrixXd X(B.rows(), B.cols());
  const auto columns = static_cast<int>(B.cols());
  const int shares = std::clamp(columns / kFewestColumns, 1, std::max(threads, 1));
  ParallelFor(shares, shares, [&](int k) {
    const SerialBlas serial;
    const int first = columns * k / shares, past = columns * (k + 1) / shares;
    SolveColumns(B.middleCols(first, past - first), X.middleCols(first, past - first));
  });
  return X;
}

void SparseCholesky::SolveColumns(const Eigen::Ref<const Eigen::MatrixXd>& B,
                                  Eigen::Ref<Eigen::MatrixXd> X) const {
  Eigen::MatrixXd by_row(std::min<Eigen::Index>(kMostColumns, B.cols()), B.rows());
  for (Eigen::Index first = 0; first < B.cols(); first += kMostColumns) {
    const Eigen::Index n = std::min<Eigen::Index>(kMostColumns, B.cols() - first);
    by_row.resize(n, B.rows());
    for (Eigen::Index i = 0; i < B.rows(); ++i) {
      by_row.col(permuted_index()[static_cast<std::size_t>(i)]) =
          B.row(i).segment(first, n).transpose();
    }
    SolveInPlace(pattern(), values(), static_cast<int>(n), by_row.data());
    for (Eigen::Index i = 0; i < B.rows(); ++i) {
      X.row(i).segment(first, n) =
          by_row.col(permuted_index()[static_cast<std::size_t>(i)]).transpose();
    }
  }
}

void SparseCholesky::SolveForward(int threads, Eigen::Ref<Eigen::MatrixXd> W) const {
  ParallelForChunks(AsSize(W.rows()), kMostColumns, threads,
                    [&](std::size_t, std::size_t first, std::size_t past) {
                      const SerialBlas serial;
                      SolveForwardInPlace(pattern(), values(), static_cast<int>(past - first),
                                          static_cast<int>(W.outerStride()), W.data() + first);
                    });
}

template <class Use>
void SparseCholesky::ForDiagonal(const Use& use) const {
  const SupernodalPattern& L = pattern();
  for (int s = 0; s < L.num_supernodes(); ++s) {
    const double* value = values() + L.value_start[AsSize(s)];
    for (int c = 0; c < L.columns(s); ++c) use(value[AsSize(c) * (AsSize(L.rows(s)) + 1)]);
  }
}

double SparseCholesky::LogDeterminant() const {
  double sum = 0.0;
  ForDiagonal([&](double l) { sum += std::log(l); });
  return 2.0 * sum;
}

double SparseCholesky::SmallestPivot() const {
  double least = std::numeric_limits<double>::infinity();
  ForDiagonal([&](double l) { least = std::min(least, l * l); });
  return least;
}

}  // namespace dn
