#include "gauss_helmert_normal.h"

namespace dn::fixed_trajectory_internal {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

NormalSums::NormalSums(Eigen::Index laser)
    : N_laser(MatrixXd::Zero(laser, laser)),
      cross(MatrixXd::Zero(laser, 3)),
      g_laser(VectorXd::Zero(laser)) {}

void NormalSums::AddLaser(const LaserColumns& columns, const Eigen::Matrix3d& S,
                          const Eigen::Matrix3d& A, const Vector3d& w) {
  for (int a = 0; a < columns.size(); ++a) {
    const Eigen::Index row = columns.unknown[static_cast<std::size_t>(a)];
    const Eigen::RowVector3d aS = columns.A.col(a).transpose() * S;
    cross.row(row) += aS * A;
    g_laser[row] += aS.dot(w);
    for (int b = 0; b < columns.size(); ++b) {
      N_laser(row, columns.unknown[static_cast<std::size_t>(b)]) += aS.dot(columns.A.col(b));
    }
  }
}

void NormalSums::operator+=(const NormalSums& other) {
  N += other.N;
  g += other.g;
  N_laser += other.N_laser;
  cross += other.cross;
  g_laser += other.g_laser;
  chi2 += other.chi2;
  chi2_conditions += other.chi2_conditions;
}

NormalSolver::NormalSolver(const NormalSums& sums) : sums_(sums), N_(sums.N) {
  if (sums.g_laser.size() == 0) return;
  laser_.compute(sums.N_laser);
  N_ -= sums.cross.transpose() * laser_.solve(sums.cross);
}

UnknownsChange NormalSolver::Solve() const {
  UnknownsChange change;
  if (sums_.g_laser.size() == 0) {
    change.boresight = -N_.llt().solve(sums_.g);
    return change;
  }
  const Vector3d g = sums_.g - sums_.cross.transpose() * laser_.solve(sums_.g_laser);
  change.boresight = -N_.llt().solve(g);
  change.laser = -laser_.solve(sums_.g_laser + sums_.cross * change.boresight);
  return change;
}

MatrixXd NormalSolver::LaserCovariance() const {
  if (sums_.g_laser.size() == 0) return {};
  const MatrixXd N = sums_.N_laser - sums_.cross * sums_.N.llt().solve(sums_.cross.transpose());
  return N.llt().solve(MatrixXd::Identity(N.rows(), N.cols()));
}

}  // namespace dn::fixed_trajectory_internal
