#pragma once

#include <dn/solvers/gauss_helmert.h>

#include <Eigen/Core>

namespace dn::internal {

/// Throws RankDeficient naming the direction where the normal matrix of a boresight leaves one free.
/// what: "point pairs"; remedy: what would determine it.
void CheckBoresightRank(const Eigen::Matrix3d& N, const char* what, const char* remedy);

/// What a prior about prior_rad adds to the normal equations of a boresight at theta_rad.
struct BoresightPrior {
  Eigen::Matrix3d N;
  Eigen::Vector3d g;
  double chi2;
};
BoresightPrior EvaluatePrior(const Eigen::Vector3d& prior_rad, const Eigen::Vector3d& sigma_rad,
                             BoresightModel model, const Eigen::Vector3d& theta_rad);

}  // namespace dn::internal
