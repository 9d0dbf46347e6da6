#pragma once

#include <dn/solvers/residual_form.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <vector>

#include "hypothesis.h"

namespace dn::diagnosis_internal {

// The smallest p of m independent tests is at most p with the probability 1 - (1 - p)^m if the
// model holds. Tests of one flight depend on each other, so m is the effective number of tests: it
// is estimated from replicates of the smallest p.

/// Returns the maximum likelihood estimate of the effective number of tests, without its bias, from
/// smallest p-values of independent replicates; at least 1. Two replicates are needed at least.
double EffectiveTests(const Eigen::VectorXd& smallest);

/// Returns the probability that the smallest p-value of that many tests is at most `smallest`.
double FamilyPValue(double smallest, double effective_tests);

/// Returns the smallest p-value of the forms for each sample of residuals (SampleFormEnergies). The
/// first forms are channels (ChannelPValue) with these redundancies, all others are tested for
/// large values. Sampled moments leave out the sample that they are compared with.
Eigen::VectorXd SmallestFormPValues(const std::vector<FormMoments>& moments,
                                    const Eigen::MatrixXd& energies,
                                    const Eigen::VectorXd& redundancy);

/// Returns the smallest p-value of the score tests of the effects of the table.
double SmallestEffectPValue(const Library& library, const JointScore& score);

/// Returns the smallest p-value of the score tests of all hypotheses for each of `draws` scores.
/// They are from the distribution under the model, N(0, score.A), with a fixed seed.
Eigen::VectorXd SmallestScorePValues(const Library& library, const JointScore& score, int draws);

}  // namespace dn::diagnosis_internal
