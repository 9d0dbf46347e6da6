#pragma once

#include <dn/adjustment/adjust.h>

namespace dn::adjustment_internal {

/// Adjusts a flight whose noise has changed since `before`: only the final least squares, with the
/// measurements that are in use there. Throws NotConverged and Interrupted.
Adjustment Readjust(const Flight& flight, const AdjustOptions& options, Adjustment before);

/// Adjusts a flight again with all stages after the alignment, from `before`. The GNSS epochs that
/// are left out there are judged again, like all others. If `before` found an error of the GNSS
/// clock and the clock is an unknown of the flight now, it starts at this error. A step of the
/// clock is not looked for again. Throws as Adjust.
Adjustment ScreenAgain(const Flight& flight, const AdjustOptions& options, Adjustment before);

}  // namespace dn::adjustment_internal
