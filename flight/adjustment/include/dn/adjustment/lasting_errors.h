#pragma once

#include <dn/calibration/candidate_effects.h>
#include <dn/flight/flight_config.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// The misclosure of a pair, linear and whitened:
///
///   r = w + A dtheta + B_i e(t_i) + B_j e(t_j),    e: position in map (m), attitude in body (rad).
struct PairRows {
  double t_i_s = 0.0, t_j_s = 0.0;
  Eigen::Vector3d w;
  Eigen::Matrix3d A;
  Eigen::Matrix<double, 3, 6> B_i, B_j;
};

/// What is known of the boresight beside the pairs, about the present values.
struct BoresightPrior {
  Eigen::Matrix3d weight = Eigen::Matrix3d::Zero();    ///< rad^-2
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< weight times (present - stated)
};

/// How much larger than stated the errors of a flight are.
struct ErrorScale {
  double position = 1.0;  ///< of the trajectory
  double attitude = 1.0;
  double white = 1.0;  ///< what is new in every pair
};

/// The pairs of a flight with the boresight and the lasting errors of the trajectory as unknowns:
/// each strip has an error constant over it, and one that is linear between nodes in time, each of
/// half the stated variance, independent of those of the other strips.
class LastingErrors {
 public:
  /// Every candidate has one part for each of the rows, in their order. strips: at least one.
  /// error_sqrt: a square root of the stated covariance of an error, position first.
  LastingErrors(const std::vector<PairRows>& rows, const std::vector<StripInterval>& strips,
                const Eigen::Matrix<double, 6, 6>& error_sqrt, const BoresightPrior& prior,
                const std::vector<CandidateEffect>& candidates);

  /// What the pairs say beside errors of one scale.
  struct AtScale {
    double log_likelihood = 0.0;  ///< without effects, and without a constant
    double chi2 = 0.0;            ///< weighted sum of squares at the solution, without effects
    /// Of the candidates. Its shift is that of the Gauss-Helmert adjustment, which takes the
    /// trajectory as given.
    JointScore score;
  };
  AtScale At(const ErrorScale& scale) const;

  /// Covariance of the Gauss-Helmert adjustment's boresight by errors of one scale, rad^2.
  Eigen::Matrix3d OfBoresight(const ErrorScale& scale) const;

  /// What is left of the sum of squares without lasting errors, with effects of this size (of all
  /// components, SI) among the unknowns, over what was left before.
  double ShareLeft(const Eigen::VectorXd& effects) const;

 private:
  Eigen::VectorXd ScaleOfUnknowns(const ErrorScale& scale) const;
  Eigen::Matrix3d NormalOfBoresight() const;

  BoresightPrior prior_;
  double rows_ = 0.0;
  double rr_ = 0.0;         // w^T w
  Eigen::VectorXd b_, Lr_;  // J^T w, L^T w; J: boresight, then errors in units of their sigma
  Eigen::MatrixXd H_, G_;   // J^T J, J^T L
  Eigen::MatrixXd LL_;      // L^T L
  std::vector<Eigen::Index> first_;
};

}  // namespace dn
