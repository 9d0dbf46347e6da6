#pragma once

#include <dn/diagnosis/diagnosis.h>

#include <vector>

#include "replicates.h"

namespace dn::diagnosis_internal {

/// Returns 1 - left / excess for the excess of a statistic before and the rest after the effects
/// are in the model. The interval follows from the deviations of the statistic of replicates, with
/// the effects, from their mean.
GapShrinkage MakeShrinkage(double excess, double left, std::vector<double> deviations);

/// A flight compared with its replicates, and the log evidence of raw inertial noise and outliers,
/// which the replicates do not contain.
struct GapEvidence {
  const ReplicateTest& test;
  double outside_nats = 0.0;
};

/// Returns the reduction of the gap: 1 - excess after / excess before. The excess is the omnibus
/// statistic, a chi-square, minus its mean over replicates, plus twice the evidence outside them.
GapShrinkage OmnibusShrinkage(const GapEvidence& before, const GapEvidence& after);

}  // namespace dn::diagnosis_internal
