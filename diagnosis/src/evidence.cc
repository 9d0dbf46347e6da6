#include "evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace dn::diagnosis_internal {

double TestFamily::FamilyWise(double p_value) const { return std::min(1.0, p_value * tests); }

double TestFamily::InSigmas(const Eigen::VectorXd& shift) const {
  return shift.cwiseQuotient(watched_sigma).cwiseAbs().maxCoeff();
}

Eigen::Vector3d TestFamily::BoresightShift(const Eigen::VectorXd& shift) const {
  if (!of_boresight) return Eigen::Vector3d::Zero();
  return shift;
}

double LogEvidence(const Hypothesis& hypothesis, const JointScore& score) {
  return SizeAveragedEvidence(SelectInformation(hypothesis, score), hypothesis.typical)
      .LogEvidence(SelectScore(hypothesis, score, score.s));
}

ScoreTest TestHypothesis(const Hypothesis& hypothesis, const JointScore& score) {
  return TestScore(SelectScore(hypothesis, score, score.s), SelectInformation(hypothesis, score),
                   SelectSignature(hypothesis, score));
}

Eigen::VectorXd ShrunkEstimate(Eigen::MatrixXd A, const Eigen::VectorXd& s,
                               const Eigen::VectorXd& typical) {
  A.diagonal() += (kMaxPerTypical * typical).cwiseAbs2().cwiseInverse();
  return -A.ldlt().solve(s);
}

Eigen::VectorXd ComponentSigmas(const ScoreTest& test) {
  return test.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

}  // namespace dn::diagnosis_internal
