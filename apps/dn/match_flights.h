#pragma once

#include <dn/lidar/point_filter.h>
#include <dn/matching/match.h>

#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// Matches the strips of several flights: those of each flight, which align it, and then those of
/// every two flights with each other. Stages the pairs between flights as
/// between_<flight>_<flight>/<strip>_<strip>.txt, and the files of AddMatchFiles. Each flight uses
/// its own trajectory, or else one smoothed from its inertial and GNSS data.
///
/// `changes`: --set values for all flights. Throws InvalidConfig for flights with several scanners
/// or with the same name, and FailedWithResults without any pair between flights.
void MatchFlights(const std::vector<std::string>& flights, const std::vector<std::string>& changes,
                  const MatchOptions& options, const PointFilter& filter, Run& run);

}  // namespace dn::apps
