#pragma once

#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <vector>

#include "hypothesis_evidence.h"

namespace dn::diagnosis_internal {

/// Columns that combine the components of a joint score into those of several fixed effects, one
/// effect after another.
struct JointColumns {
  Eigen::MatrixXd T;        ///< components of the score x components of the effects
  Eigen::VectorXd typical;  ///< typical size of each column

  Eigen::VectorXd Score(const JointScore& score) const { return T.transpose() * score.s; }
  Eigen::MatrixXd Information(const JointScore& score) const { return T.transpose() * score.A * T; }
  ScoreTest Test(const JointScore& score) const { return TestCombinations(score, T); }
};

/// Combines the columns of the fixed effects in a list. Skips noise and outliers, which have none.
JointColumns CombineFixed(const std::vector<HypothesisEvidence>& effects, const JointScore& score);

/// Sets estimate and sigma of the fixed effects in a list to those of their joint test.
void TakeJointEstimates(const ScoreTest& test, std::vector<HypothesisEvidence>* effects);

}  // namespace dn::diagnosis_internal
