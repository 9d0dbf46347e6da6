#pragma once

#include <dn/fixed_trajectory/gauss_helmert.h>

#include <Eigen/Core>

namespace dn::fixed_trajectory_internal {

/// Throws RankDeficient if the normal matrix of a boresight leaves a direction undetermined; the
/// message names the direction. `what` is the kind of observations, such as "point pairs"; `remedy`
/// says what would determine the direction.
void CheckBoresightRank(const Eigen::Matrix3d& N, const char* what, const char* remedy);

/// Contribution of a prior about prior_rad to the normal equations of a boresight at theta_rad.
struct BoresightPrior {
  Eigen::Matrix3d N;
  Eigen::Vector3d g;
  double chi2;
};
BoresightPrior EvaluatePrior(const Eigen::Vector3d& prior_rad, const Eigen::Vector3d& sigma_rad,
                             BoresightModel model, const Eigen::Vector3d& theta_rad);

}  // namespace dn::fixed_trajectory_internal
