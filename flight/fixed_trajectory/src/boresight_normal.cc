#include "boresight_normal.h"

#include <dn/error.h>
#include <dn/rotation.h>

#include <Eigen/Eigenvalues>
#include <cstdio>
#include <string>

namespace dn::fixed_trajectory_internal {

constexpr double kFreeDirection = 1e-12;  // smallest eigenvalue ratio above rounding error

void CheckBoresightRank(const Eigen::Matrix3d& N, const char* what, const char* remedy) {
  using Eigen::Vector3d;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(N);
  const Vector3d& values = eigen.eigenvalues();
  if (N.allFinite() && values[0] > kFreeDirection * values[2]) return;
  const Vector3d free = N.allFinite() ? Vector3d(eigen.eigenvectors().col(0)) : Vector3d::Zero();
  char direction[100];
  std::snprintf(direction, sizeof(direction), "%+.2f roll %+.2f pitch %+.2f yaw", free.x(),
                free.y(), free.z());
  throw RankDeficient(std::string("the ") + what +
                      " leave a direction of the boresight undetermined: " + direction + "; " +
                      remedy);
}

BoresightPrior EvaluatePrior(const Eigen::Vector3d& prior_rad, const Eigen::Vector3d& sigma_rad,
                             BoresightModel model, const Eigen::Vector3d& theta_rad) {
  const Eigen::Vector3d weight = sigma_rad.cwiseAbs2().cwiseInverse();
  Eigen::Vector3d r = theta_rad - prior_rad;
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  if (model == BoresightModel::kExponential) {
    r = Log(Eigen::Quaterniond(Exp(theta_rad) * Exp(prior_rad).conjugate()));
    J = RightJacobianInverse(-r);
  }
  return {J.transpose() * weight.asDiagonal() * J, J.transpose() * weight.cwiseProduct(r),
          r.dot(weight.cwiseProduct(r))};
}

}  // namespace dn::fixed_trajectory_internal
