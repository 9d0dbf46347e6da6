#pragma once

#include <dn/calibration/solution.h>
#include <dn/gap/diagnose.h>
#include <dn/gap/diagnosis.h>

#include <vector>

namespace dn {

/// What could be there without being found in a flight whose states are known, the most harmful
/// first: of each fixed effect that the flight's configuration does not model the minimal
/// detectable size (Baarda: a test of .001, power .8) and the minimal identifiable one (named with
/// power .8 beside all others). By geometry and stated noise alone; no measured value counts.
/// `solution` is of a flight that is adjusted, or of a design at its states. Of the options, effects,
/// left_out, seed and threads count, and `interrupted`. Throws InvalidConfig for bad options.
std::vector<HiddenEffect> HiddenOnDesign(const Solution& solution, const GapOptions& options = {});

}  // namespace dn
