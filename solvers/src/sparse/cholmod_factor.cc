#include "sparse/cholmod_factor.h"

#include <algorithm>

namespace dn::sparse {
namespace {

/// Returns a matrix as a CHOLMOD matrix without copying it.
cholmod_dense DenseView(Eigen::MatrixXd* X) {
  cholmod_dense view{};
  view.nrow = view.d = static_cast<std::size_t>(X->rows());
  view.ncol = static_cast<std::size_t>(X->cols());
  view.nzmax = view.nrow * view.ncol;
  view.x = X->data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

}  // namespace

CholmodFactor::CholmodFactor(const cholmod_factor& analysed)
    : L_(cholmod_copy_factor(const_cast<cholmod_factor*>(&analysed), common_.get())) {
  common_.Check("copying the analysis");
  common_->quick_return_if_not_posdef = 1;
}

bool CholmodFactor::Factorize(const SymmetricCsc& A, double shift, int /*threads*/) {
  cholmod_sparse view = View(A);
  double beta[2] = {shift, 0.0};
  cholmod_factorize_p(&view, beta, nullptr, 0, L_.get(), common_.get());
  common_.Check("factoring");
  return L_->minor == L_->n;
}

/// Calls halves(L, X^T, workspace, common), which solves with L, L^T or both.
template <class Halves>
void CholmodFactor::SolveTransposed(Eigen::Ref<Eigen::MatrixXd> X, const Halves& halves) const {
  CholmodCommon common;
  Eigen::MatrixXd by_column = X.transpose();
  Eigen::MatrixXd work(X.rows(),
                       std::max<Eigen::Index>(static_cast<Eigen::Index>(L_->maxesize), 1));
  cholmod_dense view = DenseView(&by_column), E = DenseView(&work);
  halves(L_.get(), &view, &E, common.get());
  common.Check("solving");
  X = by_column.transpose();
}

void CholmodFactor::SolveInPlace(Eigen::Ref<Eigen::MatrixXd> X) const {
  SolveTransposed(X, [](auto* L, auto* view, auto* E, auto* common) {
    cholmod_super_lsolve(L, view, E, common);
    cholmod_super_ltsolve(L, view, E, common);
  });
}

void CholmodFactor::SolveForwardInPlace(Eigen::Ref<Eigen::MatrixXd> X) const {
  SolveTransposed(X, [](auto* L, auto* view, auto* E, auto* common) {
    cholmod_super_lsolve(L, view, E, common);
  });
}

}  // namespace dn::sparse
