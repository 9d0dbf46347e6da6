#pragma once

#include <dn/fixed_trajectory/laser_unknowns.h>

#include <Eigen/Core>
#include <string>

namespace dn::fixed_trajectory_internal {

/// Throws InvalidInput if a term names none of the unknowns, or is not finite. `name` is that of
/// the end.
void CheckLaserTerms(const LaserTerms& terms, const LaserUnknowns& unknowns,
                     const std::string& name);

/// Throws InvalidInput if the sizes differ, or the information is not positive definite.
void CheckLaserUnknowns(const LaserUnknowns& unknowns);

/// Contribution of the prior to the normal equations, besides its information.
struct LaserPrior {
  Eigen::VectorXd g;
  double chi2;
};
/// Evaluates the prior at this change of the unknowns from their start.
LaserPrior EvaluateLaserPrior(const LaserUnknowns& unknowns, const Eigen::VectorXd& change);

}  // namespace dn::fixed_trajectory_internal
