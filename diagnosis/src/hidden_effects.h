#pragma once

#include <dn/gap/diagnosis.h>

#include <cstdint>
#include <vector>

#include "screen.h"

namespace dn::internal {

/// What could be there without being found, the most harmful first. Minimal detectable: found with
/// probability .8 by a test of .001 of its best-determined direction (Baarda). Minimal identifiable:
/// named with probability .8 by the decision on the scores of the whole library, competing with all
/// others, at sizes up to `kLargest` usual ones. By geometry alone; no measured value is used.
std::vector<HiddenEffect> HiddenEffects(const Screen& screen, double threshold_nats,
                                        std::uint64_t seed);

}  // namespace dn::internal
