#pragma once

#include <dn/diagnosis/diagnosis.h>

#include <cstdint>
#include <vector>

#include "screen.h"

namespace dn::diagnosis_internal {

/// Returns the detection limits of all fixed effects, largest shift of the boresight first. The
/// minimal detectable bias is found with probability 0.8 by a test of level 0.001 of its
/// best-determined direction (Baarda). The minimal identifiable size is named with probability 0.8
/// when the effect competes with the whole library. Sizes up to 100 times the typical one are
/// tried. Both depend on the geometry alone; no measured value is used.
std::vector<DetectionLimit> ComputeDetectionLimits(const Screen& screen, double threshold_nats,
                                                   std::uint64_t seed);

}  // namespace dn::diagnosis_internal
