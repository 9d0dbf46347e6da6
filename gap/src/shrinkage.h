#pragma once

#include <dn/gap/diagnosis.h>

#include "twins.h"

namespace dn::internal {

/// How far the omnibus statistic comes down to that of its own twins: 1 - excess after / excess
/// before, with the interval by the scatter of the twins after.
GapShrinkage OmnibusShrinkage(const TwinTest& before, const TwinTest& after);

}  // namespace dn::internal
