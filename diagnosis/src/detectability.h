#pragma once

#include <dn/adjustment/checks.h>
#include <dn/effects/unmodelled_prior.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <vector>

#include "evidence.h"
#include "hypothesis.h"

namespace dn::diagnosis_internal {

/// A signature is absorbed by the unknowns if they leave less than this share of its squared
/// length, which is rounding error.
inline constexpr double kAbsorbedShare = 1e-7;

/// Returns the minimal detectable bias (Baarda, see OutlierTest) in units of the signature. It is
/// infinite if the unknowns absorb the signature.
double MinimalDetectableBias(double information, double signature2);

/// Returns the minimal detectable bias of each component of a hypothesis alone, SI.
Eigen::VectorXd MinimalDetectableBiases(const Hypothesis& hypothesis, const JointScore& score);

/// Returns the undetectable effects: they would be harmful at their typical size, but are below
/// their minimal detectable bias. The largest shift comes first; among hypotheses of one name only
/// the one with the largest shift counts. Effects with a prior are in the covariance and left out.
/// `score` is that of the library, with the watched unknowns
/// of the family in its shift.
std::vector<UndetectableEffect> FindUndetectable(const Library& library, const JointScore& score,
                                                 const TestFamily& family,
                                                 const UnmodelledPrior& prior);

}  // namespace dn::diagnosis_internal
