#include <dn/symmetric_eigen.h>

#include <Eigen/Eigenvalues>

namespace dn {

SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
}

}  // namespace dn
