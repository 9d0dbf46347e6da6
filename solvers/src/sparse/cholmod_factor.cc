#include "sparse/cholmod_factor.h"

#include <algorithm>

namespace dn::sparse {
namespace {

/// Returns a matrix as a CHOLMOD matrix without copying it.
cholmod_dense View(Eigen::MatrixXd* X) {
  cholmod_dense view{};
  view.nrow = view.d = static_cast<std::size_t>(X->rows());
  view.ncol = static_cast<std::size_t>(X->cols());
  view.nzmax = view.nrow * view.ncol;
  view.x = X->data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

/// Calls steps(X, workspace, common) with the arguments of CHOLMOD's triangular solutions.
template <class Steps>
void SolveBy(const Steps& steps, const cholmod_factor& L, Eigen::MatrixXd* X) {
  CholmodCommon common;
  Eigen::MatrixXd work(X->cols(), static_cast<Eigen::Index>(std::max<std::size_t>(L.maxesize, 1)));
  cholmod_dense view = View(X), work_view = View(&work);
  steps(&view, &work_view, common.get());
  common.Check("solving");
}

}  // namespace

CholmodFactor::CholmodFactor(const cholmod_factor& analysed)
    : L_(cholmod_copy_factor(const_cast<cholmod_factor*>(&analysed), common_.get())) {
  common_.Check("copying the analysis");
  common_->quick_return_if_not_posdef = 1;
}

bool CholmodFactor::Factorize(const SymmetricCsc& A, double shift) {
  cholmod_sparse view = sparse::View(A);
  double beta[2] = {shift, 0.0};
  cholmod_factorize_p(&view, beta, nullptr, 0, L_.get(), common_.get());
  common_.Check("factoring");
  return L_->minor == L_->n;
}

void CholmodFactor::Solve(Eigen::MatrixXd* X) const {
  SolveBy(
      [this](auto* x, auto* work, auto* common) {
        cholmod_super_lsolve(L_.get(), x, work, common);
        cholmod_super_ltsolve(L_.get(), x, work, common);
      },
      *L_, X);
}

void CholmodFactor::SolveForward(Eigen::MatrixXd* X) const {
  SolveBy([this](auto* x, auto* work,
                 auto* common) { cholmod_super_lsolve(L_.get(), x, work, common); },
          *L_, X);
}

}  // namespace dn::sparse
