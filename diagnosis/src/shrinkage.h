#pragma once

#include <dn/diagnosis/diagnosis.h>

#include "twins.h"

namespace dn::internal {

/// A flight compared with its replicates, and the log evidence of raw inertial noise and outliers,
/// which the replicates do not contain.
struct Departure {
  const ReplicateTest& test;
  double outside_nats = 0.0;
};

/// Returns the reduction of the gap: 1 - excess after / excess before. The excess is the omnibus
/// statistic, a chi-square, minus its mean over replicates, plus twice the evidence outside them.
/// The interval follows from the variation of the replicates with the effects.
GapShrinkage OmnibusShrinkage(const Departure& before, const Departure& after);

}  // namespace dn::internal
