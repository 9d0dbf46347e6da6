#include "laser_prior.h"

#include <dn/error.h>

#include <Eigen/Cholesky>

namespace dn::fixed_trajectory_internal {

void CheckLaserTerms(const LaserTerms& terms, const LaserUnknowns& unknowns,
                     const std::string& name) {
  for (const LaserTerm& term : terms) {
    if (term.unknown < unknowns.size() && term.direction_b.allFinite()) continue;
    throw InvalidInput(
        name + ": a term of the laser vector names none of the unknowns, or is not " + "finite");
  }
}

void CheckLaserUnknowns(const LaserUnknowns& unknowns) {
  const Eigen::Index n = unknowns.size();
  const bool fits = unknowns.information.rows() == n && unknowns.information.cols() == n;
  if (n == 0 && fits) return;
  if (fits && unknowns.start.allFinite() && unknowns.information.allFinite() &&
      Eigen::LLT<Eigen::MatrixXd>(unknowns.information).info() == Eigen::Success) {
    return;
  }
  throw InvalidInput(
      "the prior of the laser unknowns is not positive definite, or has another size");
}

LaserPrior EvaluateLaserPrior(const LaserUnknowns& unknowns, const Eigen::VectorXd& change) {
  const Eigen::VectorXd x = unknowns.start + change;
  LaserPrior prior{unknowns.information * x, 0.0};
  prior.chi2 = x.dot(prior.g);
  return prior;
}

}  // namespace dn::fixed_trajectory_internal
