#pragma once

#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/diagnosis.h>
#include <dn/diagnosis/solution.h>

#include <vector>

namespace dn {

/// Returns the detection limits of a flight with known states, largest shift of the boresight
/// first. There are two sizes for each fixed effect that the configuration does not model. The
/// minimal detectable bias is found by a test of level 0.001 with power 0.8 (Baarda). The minimal
/// identifiable size is named correctly with power 0.8 among all other effects. Both depend on
/// geometry and stated noise alone; no measured value is used.
///
/// `solution` belongs to an adjusted flight, or to a design at its assumed states. Only the options
/// `effects`, `left_out`, `seed`, `threads` and `interrupted` are used. Throws InvalidConfig for
/// invalid options, and Interrupted.
std::vector<DetectionLimit> DesignDetectionLimits(const Solution& solution,
                                                  const GapOptions& options = {});

}  // namespace dn
