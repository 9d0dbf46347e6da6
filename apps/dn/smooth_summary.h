#pragma once

#include <dn/adjustment/filter_separation.h>

#include "flight_run.h"

namespace dn::apps {

/// Prints the summary of a smoothed trajectory with its tables: agreement of data and model,
/// accuracy, forward/reverse separation and clocks.
void PrintSmoothSummary(const FlightRun& flight_run, const FilterSeparation& separation,
                        const Json& reference_errors);

}  // namespace dn::apps
