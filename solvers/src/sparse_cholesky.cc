#include "sparse_cholesky.h"

#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <string>

#include "serial_blas.h"

namespace dn {
namespace {

/// A as CHOLMOD sees it, without a copy; only its pattern where it has no values.
cholmod_sparse View(const SymmetricCsc& A) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(A.n);
  view.nzmax = A.row.size();
  view.p = const_cast<int*>(A.column_start.data());
  view.i = const_cast<int*>(A.row.data());
  view.x = A.value.empty() ? nullptr : const_cast<double*>(A.value.data());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = A.value.empty() ? CHOLMOD_PATTERN : CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

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

/// Fewer right-hand sides than this are not worth a thread.
constexpr Eigen::Index kFewestColumns = 8;

/// What a thread needs for a solution of its own.
class Workspace {
 public:
  Workspace() : common_(std::make_unique<cholmod_common>()) {
    cholmod_start(common_.get());
    common_->print = 0;
    common_->try_catch = 1;
  }
  ~Workspace() { cholmod_finish(common_.get()); }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  cholmod_common* common() const { return common_.get(); }

 private:
  std::unique_ptr<cholmod_common> common_;
};

}  // namespace

SparseCholesky::SparseCholesky(const SymmetricCsc& A, const SymmetricCsc& blocks,
                               const UnknownLayout& layout) {
  Start();
  std::vector<int> order = ExpandOrder(BlockOrder(blocks), layout);
  cholmod_sparse view = View(A);
  factor_ = cholmod_analyze_p(&view, order.data(), nullptr, 0, &common_);
  CheckStatus("analysing");
  permuted_index_.resize(static_cast<std::size_t>(A.n));
  const int* permutation = static_cast<const int*>(factor_->Perm);
  for (int i = 0; i < A.n; ++i) permuted_index_[static_cast<std::size_t>(permutation[i])] = i;
}

SparseCholesky::SparseCholesky(const SparseCholesky& analysed)
    : permuted_index_(analysed.permuted_index_) {
  Start();
  factor_ = cholmod_copy_factor(analysed.factor_, &common_);
  CheckStatus("analysing");
}

void SparseCholesky::Start() {
  cholmod_start(&common_);
  common_.print = 0;
  common_.try_catch = 1;
  common_.nmethods = 1;
  common_.method[0].ordering = CHOLMOD_GIVEN;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.final_ll = 1;
  common_.quick_return_if_not_posdef = 1;
}

SparseCholesky::~SparseCholesky() {
  cholmod_free_factor(&factor_, &common_);
  cholmod_finish(&common_);
}

std::vector<int> SparseCholesky::BlockOrder(const SymmetricCsc& blocks) {
  std::vector<int> order(static_cast<std::size_t>(blocks.n));
  // CHOLMOD's AMD takes an upper triangle, or what it makes one of: copy the transpose.
  cholmod_sparse lower = View(blocks);
  cholmod_sparse* upper = cholmod_transpose(&lower, 0, &common_);
  CheckStatus("ordering");
  cholmod_amd(upper, nullptr, 0, order.data(), &common_);
  cholmod_free_sparse(&upper, &common_);
  CheckStatus("ordering");
  return order;
}

void SparseCholesky::CheckStatus(const cholmod_common& common, const char* step) {
  if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (common.status == CHOLMOD_TOO_LARGE) {
    throw InvalidInput("marginals: the factor of the normal matrix is too large; use fewer nodes");
  }
  if (common.status < CHOLMOD_OK) {
    throw std::runtime_error(std::string("marginals: CHOLMOD failed while ") + step + ", status " +
                             std::to_string(common.status));
  }
}

bool SparseCholesky::Factorize(const SymmetricCsc& A, double shift) {
  cholmod_sparse view = View(A);
  double beta[2] = {shift, 0.0};
  cholmod_factorize_p(&view, beta, nullptr, 0, factor_, &common_);
  CheckStatus("factoring");
  return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
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
  const Workspace workspace;
  cholmod_common* common = workspace.common();
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(B.rows());
  view.d = static_cast<std::size_t>(B.outerStride());
  view.ncol = static_cast<std::size_t>(B.cols());
  view.nzmax = view.d * view.ncol;
  view.x = B.data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, &view, common);
  CheckStatus(*common, "solving");
  B = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), B.rows(),
                                        B.cols());
  cholmod_free_dense(&solution, common);
}

double SparseCholesky::LogDeterminant() const {
  const SupernodalView L = view();
  double sum = 0.0;
  for (int s = 0; s < L.num_supernodes; ++s) {
    const int rows = L.row_start[s + 1] - L.row_start[s];
    const int columns = L.column[s + 1] - L.column[s];
    const double* value = L.value + L.value_start[s];
    for (int c = 0; c < columns; ++c) sum += std::log(value[c * (rows + 1)]);
  }
  return 2.0 * sum;
}

SupernodalView SparseCholesky::view() const {
  SupernodalView view;
  view.num_supernodes = static_cast<int>(factor_->nsuper);
  view.column = static_cast<const int*>(factor_->super);
  view.row_start = static_cast<const int*>(factor_->pi);
  view.value_start = static_cast<const int*>(factor_->px);
  view.row = static_cast<const int*>(factor_->s);
  view.value = static_cast<const double*>(factor_->x);
  view.num_values = factor_->xsize;
  return view;
}

long SparseCholesky::num_nonzeros() const { return static_cast<long>(factor_->xsize); }

}  // namespace dn
