#pragma once

#include <dn/flight/flight_config.h>

#include <functional>
#include <string>

#include "command.h"

namespace dn::apps {

/// Whether a flight has point clouds, and no pair file that it names is there.
bool HasStripsAlone(const FlightConfig& config);

/// Matches the strips of such a flight, stages what `dn match` writes (a trajectory that had to be
/// smoothed as smoothed/trajectory.out), and calls `calibrate` with the flight that has the pairs.
void CalibrateStrips(const FlightConfig& config, const std::string& trajectory, Run& run,
                     const std::function<void(const FlightConfig&)>& calibrate);

}  // namespace dn::apps
