#include "sparse/cholesky.h"

#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "sparse/cholmod_factor.h"
#include "sparse/elimination_order.h"
#include "sparse/serial_blas.h"

namespace dn::sparse {
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

std::vector<int> Inverse(const int* permutation, std::size_t n) {
  std::vector<int> inverse(n);
  for (std::size_t i = 0; i < n; ++i) inverse[AsSize(permutation[i])] = static_cast<int>(i);
  return inverse;
}

/// Minimum number of right-hand sides per thread.
constexpr int kFewestColumns = 8;
/// Maximum number of right-hand sides solved together.
constexpr int kMostColumns = 16;

}  // namespace

/// Data that depend only on the pattern.
struct Cholesky::Analysis {
  CholmodFactorPointer symbolic;
  std::vector<int> permuted_index;
  SupernodalPattern pattern;
  SupernodeTree tree;

  explicit Analysis(CholmodFactorPointer analysed)
      : symbolic(std::move(analysed)),
        permuted_index(Inverse(static_cast<const int*>(symbolic->Perm), symbolic->n)),
        pattern(CopyPattern(*symbolic)),
        tree(pattern) {}
};

Cholesky::Cholesky(const SymmetricCsc& A, const SymmetricCsc& blocks, const UnknownLayout& layout) {
  CholmodCommon common;
  common->nmethods = 1;
  common->method[0].ordering = CHOLMOD_GIVEN;
  common->supernodal = CHOLMOD_SUPERNODAL;
  const EliminationOrder elimination = FindEliminationOrder(blocks, layout.size());
  std::vector<int> order = ExpandOrder(elimination.position, layout);
  cholmod_sparse view = View(A);
  CholmodFactorPointer symbolic(cholmod_analyze_p(&view, order.data(), nullptr, 0, common.get()));
  common.Check("analysing");
  analysis_ = std::make_shared<const Analysis>(std::move(symbolic));
}

Cholesky::Cholesky(const Cholesky& analysed) : analysis_(analysed.analysis_) {}

Cholesky::~Cholesky() = default;

const SupernodalPattern& Cholesky::pattern() const { return analysis_->pattern; }
const SupernodeTree& Cholesky::tree() const { return analysis_->tree; }
const double* Cholesky::values() const { return factor_->values(); }
const std::vector<int>& Cholesky::permuted_index() const { return analysis_->permuted_index; }

template <class Use>
void Cholesky::ForDiagonal(const Use& use) const {
  const SupernodalPattern& L = pattern();
  for (int s = 0; s < L.num_supernodes(); ++s) {
    const double* value = values() + L.value_start[AsSize(s)];
    for (int c = 0; c < L.columns(s); ++c) use(value[AsSize(c) * (AsSize(L.rows(s)) + 1)]);
  }
}

bool Cholesky::Factorize(const SymmetricCsc& A, double shift) {
  if (!factor_) factor_ = std::make_unique<CholmodFactor>(*analysis_->symbolic);
  return factor_->Factorize(A, shift) && PivotsArePositive();
}

bool Cholesky::PivotsArePositive() const {
  bool positive = true;
  ForDiagonal([&](double l) { positive = positive && l > 0.0; });
  return positive;
}

Eigen::MatrixXd Cholesky::Solve(const Eigen::MatrixXd& B, int threads) const {
  Eigen::MatrixXd X(B.rows(), B.cols());
  const auto columns = static_cast<int>(B.cols());
  const int shares = std::clamp(columns / kFewestColumns, 1, std::max(threads, 1));
  ParallelFor(shares, shares, [&](int k) {
    const SerialBlas serial;
    SolveColumns(B, columns * k / shares, columns * (k + 1) / shares, &X);
  });
  return X;
}

void Cholesky::SolveColumns(const Eigen::MatrixXd& B, Eigen::Index first, Eigen::Index past,
                            Eigen::MatrixXd* X) const {
  const std::vector<int>& row = permuted_index();
  Eigen::MatrixXd permuted;
  for (; first < past; first += kMostColumns) {
    const Eigen::Index n = std::min<Eigen::Index>(kMostColumns, past - first);
    permuted.resize(B.rows(), n);
    permuted(row, Eigen::all) = B.middleCols(first, n);
    factor_->Solve(&permuted);
    X->middleCols(first, n) = permuted(row, Eigen::all);
  }
}

// A Ref is a view, which is cheap to copy.
// NOLINTNEXTLINE(performance-unnecessary-value-param)
void Cholesky::SolveInPlace(Eigen::Ref<Eigen::MatrixXd> W) const {
  Eigen::MatrixXd by_column = W.transpose();
  factor_->Solve(&by_column);
  W = by_column.transpose();
}

void Cholesky::SolveForward(int threads, Eigen::Ref<Eigen::MatrixXd> W) const {
  ParallelForChunks(AsSize(W.rows()), kMostColumns, threads,
                    [&](std::size_t, std::size_t first, std::size_t past) {
                      const SerialBlas serial;
                      auto rows = W.middleRows(static_cast<Eigen::Index>(first),
                                               static_cast<Eigen::Index>(past - first));
                      Eigen::MatrixXd by_column = rows.transpose();
                      factor_->SolveForward(&by_column);
                      rows = by_column.transpose();
                    });
}

double Cholesky::LogDeterminant() const {
  double sum = 0.0;
  ForDiagonal([&](double l) { sum += std::log(l); });
  return 2.0 * sum;
}

double Cholesky::SmallestPivot() const {
  double least = std::numeric_limits<double>::infinity();
  ForDiagonal([&](double l) { least = std::min(least, l * l); });
  return least;
}

}  // namespace dn::sparse
