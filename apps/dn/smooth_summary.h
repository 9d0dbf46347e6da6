#pragma once

#include <dn/calibration/filter_separation.h>

#include "flight_run.h"

namespace dn::apps {

/// Prints what a person asks first of a smoothed trajectory, and the tables behind it: whether the
/// data agree with the model, how accurate it is, what the two filters say, the clocks.
void PrintSmoothSummary(const FlightRun& flight_run, const FilterSeparation& separation,
                        const Json& reference_errors);

}  // namespace dn::apps
