#include "sparse_cholesky.h"

#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
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

/// Fewer right-hand sides than this are not worth a thread.
constexpr Eigen::Index kFewestColumns = 8;

}  // namespace

SparseCholesky::SparseCholesky(const SymmetricCsc& A, const SymmetricCsc& blocks,
                               const UnknownLayout& layout) {
  Start();
  const EliminationOrder elimination = FindEliminationOrder(blocks, layout.size());
  std::vector<int> order = ExpandOrder(elimination.position, layout);
  cholmod_sparse view = View(A);
  factor_ = cholmod_analyze_p(&view, order.data(), nullptr, 0, common_.get());
  common_.Check("analysing");
  permuted_index_.resize(static_cast<std::size_t>(A.n));
  const int* permutation = static_cast<const int*>(factor_->Perm);
  for (int i = 0; i < A.n; ++i) permuted_index_[static_cast<std::size_t>(permutation[i])] = i;
  multifrontal_ = std::make_shared<const Multifrontal>(A, permuted_index_, PatternOf(*factor_));
}

SparseCholesky::SparseCholesky(const SparseCholesky& analysed)
    : permuted_index_(analysed.permuted_index_), multifrontal_(analysed.multifrontal_) {
  Start();
  factor_ = cholmod_copy_factor(analysed.factor_, common_.get());
  common_.Check("analysing");
}

void SparseCholesky::Start() {
  common_->nmethods = 1;
  common_->method[0].ordering = CHOLMOD_GIVEN;
  common_->supernodal = CHOLMOD_SUPERNODAL;
  common_->final_ll = 1;
  common_->quick_return_if_not_posdef = 1;
}

SparseCholesky::~SparseCholesky() { cholmod_free_factor(&factor_, common_.get()); }

bool SparseCholesky::Factorize(const SymmetricCsc& A, double shift, int threads) {
  if (factor_->x == nullptr) {
    cholmod_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, factor_, common_.get());
    common_.Check("factoring");
  }
  return multifrontal_->Factorize(A, shift, threads, static_cast<double*>(factor_->x));
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
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, &view, common.get());
  common.Check("solving");
  B = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), B.rows(),
                                        B.cols());
  cholmod_free_dense(&solution, common.get());
}

double SparseCholesky::LogDeterminant() const {
  const SupernodalPattern& L = pattern();
  double sum = 0.0;
  for (int s = 0; s < L.num_supernodes(); ++s) {
    const double* value = values() + L.value_start[AsSize(s)];
    for (int c = 0; c < L.columns(s); ++c) sum += std::log(value[c * (L.rows(s) + 1)]);
  }
  return 2.0 * sum;
}

long SparseCholesky::num_nonzeros() const { return static_cast<long>(factor_->xsize); }

}  // namespace dn
