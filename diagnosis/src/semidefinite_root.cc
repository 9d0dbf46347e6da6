#include "semidefinite_root.h"

#include <cmath>

namespace dn::diagnosis_internal {

Eigen::MatrixXd SemidefiniteRoot(const Eigen::MatrixXd& C, const Eigen::VectorXd& rounding) {
  const Eigen::Index n = C.rows();
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double pivot = C(j, j) - L.row(j).head(j).squaredNorm();
    if (!(pivot > rounding[j])) continue;
    const Eigen::Index below = n - j - 1;
    L(j, j) = std::sqrt(pivot);
    L.col(j).tail(below) = C.col(j).tail(below);
    L.col(j).tail(below).noalias() -= L.bottomLeftCorner(below, j) * L.row(j).head(j).transpose();
    L.col(j).tail(below) /= L(j, j);
  }
  return L;
}

}  // namespace dn::diagnosis_internal
