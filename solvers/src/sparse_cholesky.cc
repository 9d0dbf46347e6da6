#include "sparse_cholesky.h"

#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <string>

#include "elimination_order.h"
#include "serial_blas.h"

namespace dn {
namespace {

std::vector<int> ExpandOrder(const std::vector<int>& block_order, const UnknownLayout& layout) {
  std::vector<int> order;
  order.reserve(static_cast<std::size_t>(layout.size()));
  for (const int position : block_order) {
    for (int k = 0; k < layout.size_of(position); ++k) {
      order.push_back(layout.offset[static_cast<std::size_t>(position)] + k);
    }
  }
  return order;
}

SupernodalPattern PatternOf(const cholmod_factor& factor) {
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

/// Fewer right-hand sides than this are not worth a thread.
constexpr Eigen::Index kFewestColumns = 8;

}  // namespace

SparseCholesky::Analysis::Analysis(const SymmetricCsc& A, cholmod_factor* analysed)
    : factor(analysed),
      permuted_index(Inverse(static_cast<const int*>(analysed->Perm), A.n)),
      numbers(A, permuted_index, PatternOf(*analysed)) {}

SparseCholesky::Analysis::~Analysis() {
  CholmodCommon common;
  cholmod_free_factor(&factor, common.get());
}

SparseCholesky::SparseCholesky(const SymmetricCsc& A, const SymmetricCsc& blocks,
                               const UnknownLayout& layout) {
  CholmodCommon common;
  common->nmethods = 1;
  common->method[0].ordering = CHOLMOD_GIVEN;
  common->supernodal = CHOLMOD_SUPERNODAL;
  const EliminationOrder elimination = FindEliminationOrder(blocks, layout.size());
  std::vector<int> order = ExpandOrder(elimination.position, layout);
  cholmod_sparse view = View(A);
  cholmod_factor* factor = cholmod_analyze_p(&view, order.data(), nullptr, 0, common.get());
  common.Check("analysing");
  analysis_ = std::make_shared<const Analysis>(A, factor);
}

bool SparseCholesky::Factorize(const SymmetricCsc& A, double shift, int threads) {
  if (!values_) values_.reset(new double[pattern().num_values]);
  return analysis_->numbers.Factorize(A, shift, threads, values_.get());
}

Eigen::MatrixXd SparseCholesky::Solve(const Eigen::MatrixXd& B, int threads) const {
  Eigen::MatrixXd X = B;
  const Eigen::Index shares =
      std::clamp<Eigen::Index>(B.cols() / kFewestColumns, 1, std::max(threads, 1));
  ParallelFor(static_cast<int>(shares), static_cast<int>(shares), [&](int k) {
    const Eigen::Index first = B.cols() * k / shares, past = B.cols() * (k + 1) / shares;
    SolveColumns(X.middleCols(first, past - first));
  });
  return X;
}

void SparseCholesky::SolveColumns(Eigen::Ref<Eigen::MatrixXd> B) const {
  const SerialBlas serial;
  CholmodCommon common;
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(B.rows());
  view.d = static_cast<std::size_t>(B.outerStride());
  view.ncol = static_cast<std::size_t>(B.cols());
  view.nzmax = view.d * view.ncol;
  view.x = B.data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_factor L = *analysis_->factor;
  L.x = values_.get();
  L.xtype = CHOLMOD_REAL;
  L.is_ll = 1;
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, &L, &view, common.get());
  common.Check("solving");
  B = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), B.rows(),
                                        B.cols());
  cholmod_free_dense(&solution, common.get());
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

double SparseCholesky::LeastPivot() const {
  double least = std::numeric_limits<double>::infinity();
  ForDiagonal([&](double l) { least = std::min(least, l * l); });
  return least;
}

}  // namespace dn
