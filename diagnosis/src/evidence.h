#pragma once

#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <vector>

#include "hypothesis.h"

namespace dn::diagnosis_internal {

/// Family-wise significance level, for all tests of one flight, of a doubt about the model.
inline constexpr double kFamilyLevel = 1e-3;
// Hypotheses whose evidence is within this of the best one are nearly as likely.
inline constexpr double kEquallyLikelyNats = 3.0;
// Estimates much larger than this many typical sizes are shrunk towards zero, so that components
// that the data do not determine cause no shift.
inline constexpr double kMaxPerTypical = 30.0;

/// The tests of one flight, and the unknowns whose shifts count.
struct TestFamily {
  double tests = 1.0;             ///< number of tests
  Eigen::VectorXd watched_sigma;  ///< sigmas of the first coordinates in JointScore::shift
  bool of_boresight = true;       ///< true: these coordinates are the three angles

  /// Returns a p-value times the number of tests, at most 1.
  double FamilyWise(double p_value) const;
  /// Returns the largest shift of a watched unknown, in its sigmas.
  double InSigmas(const Eigen::VectorXd& shift) const;
  /// Returns the part of a shift that is of the boresight; zero if the unknowns are others.
  Eigen::Vector3d BoresightShift(const Eigen::VectorXd& shift) const;
};

/// Returns the log of the likelihood ratio with and without a hypothesis, averaged over its size:
/// Gaussian with 0.1 to 10 typical sizes.
double LogEvidence(const Hypothesis& hypothesis, const JointScore& score);

/// Returns the joint score test of all components of a hypothesis.
ScoreTest TestHypothesis(const Hypothesis& hypothesis, const JointScore& score);

/// Returns joint estimates of the components, SI, shrunk towards zero if they are well above
/// kMaxPerTypical typical sizes. A is their information, s their score.
Eigen::VectorXd ShrunkEstimate(Eigen::MatrixXd A, const Eigen::VectorXd& s,
                               const Eigen::VectorXd& typical);

/// Returns the standard deviations of the components of a test.
Eigen::VectorXd ComponentSigmas(const ScoreTest& test);

}  // namespace dn::diagnosis_internal
