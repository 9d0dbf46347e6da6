#pragma once

#include <dn/gap/diagnosis.h>

#include "twins.h"

namespace dn::internal {

/// A flight beside its twins, and what the twins cannot have: raw inertial noise and gross errors,
/// log evidence.
struct Departure {
  const TwinTest& test;
  double outside_nats = 0.0;
};

/// How far the omnibus statistic, a chi-square, comes down to that of its own twins, twice the log
/// evidence outside them included: 1 - excess after / excess before, with the interval by the
/// scatter of the twins after.
GapShrinkage OmnibusShrinkage(const Departure& before, const Departure& after);

}  // namespace dn::internal
