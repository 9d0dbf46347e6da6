#pragma once

#include <dn/adjustment/stages.h>
#include <dn/navigation/gnss_steps.h>

namespace dn::adjustment_internal {

/// Returns whether a step of the GNSS clock, found to first order, is the cause of a misfit. The
/// tags are corrected from the step on, and the INS/GNSS network of these tags is solved. This is
/// repeated if a part of the step is left. The squared residuals must fall by half of their excess,
/// and by half of what the test of the step predicts.
bool StepExplains(AdjustmentRun& run, const GnssMisfit& misfit);

/// Screens the GNSS epochs as ScreenGnss does, but does not look for a step of the clock, which
/// takes most of the time.
void ScreenGnssOutliers(AdjustmentRun& run);

}  // namespace dn::adjustment_internal
