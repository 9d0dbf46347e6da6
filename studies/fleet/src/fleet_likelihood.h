#pragma once

#include <dn/fleet/reduced_flight.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "fleet_unknowns.h"

namespace dn::fleet_internal {

/// Likelihood of all flights, as a function of
///
///   y = [boresight of each flight, left rotation from `reference_rad`; shared effects]:
///
///   -2 log = y^T information y - 2 y^T vector + constant,
///
/// and the priors of the boresight and of the effects, which count once.
struct FleetLikelihood {
  Eigen::Vector3d reference_rad = Eigen::Vector3d::Zero();
  Eigen::Index flights = 0, effects = 0;
  Eigen::MatrixXd information;
  Eigen::VectorXd vector;
  Eigen::Matrix3d prior_information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d prior_vector = Eigen::Vector3d::Zero();
  Eigen::VectorXd effect_prior;  ///< information of each component; 0 without a prior
};

/// Returns the left rotation that turns the reference into these angles.
Eigen::Vector3d TurnFromReference(const Eigen::Vector3d& angles_rad,
                                  const Eigen::Vector3d& reference_rad);

/// Returns the mean boresight of a flight as a left rotation from the reference.
Eigen::Vector3d MeanBoresight(const ReducedFlight& flight, const Eigen::Vector3d& reference_rad);

/// Multiplies the likelihoods of the flights. Throws InvalidConfig if flights state different
/// priors of the boresight.
FleetLikelihood MakeLikelihood(const std::vector<ReducedFlight>& flights,
                               const SharedUnknowns& shared);

/// Estimates with a random walk of the boresight, of the standard deviation `walk_rad` per flight
/// and angle; 0: the boresight is constant. The unknowns are
///
///   x = [boresight of the first flight; steps in units of walk_rad; shared effects],   y = T x.
class FleetEstimate {
 public:
  FleetEstimate(const FleetLikelihood& likelihood, double walk_rad);

  /// Returns mean and covariance of y.
  Eigen::VectorXd Mean() const { return T_ * x_; }
  Eigen::MatrixXd Covariance(const Eigen::MatrixXd& rows) const;
  /// Returns the matrix that selects the boresight of a flight, or the shared effects, from y.
  Eigen::MatrixXd BoresightRows(Eigen::Index flight) const;
  Eigen::MatrixXd EffectRows() const;

  /// Returns log |likelihood of the data, integrated over all unknowns|, up to a constant that does
  /// not depend on the walk.
  double LogLikelihood() const;

  /// Returns the score of y, vector - information y, and its covariance for data that follow the
  /// model.
  Eigen::VectorXd Score() const;
  Eigen::MatrixXd ScoreCovariance() const;

 private:
  const FleetLikelihood& likelihood_;
  Eigen::MatrixXd T_;
  Eigen::VectorXd g_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  Eigen::VectorXd x_;
};

}  // namespace dn::fleet_internal
