#pragma once

#include <dn/files/flight_config.h>

#include <functional>
#include <string>

#include "command.h"

namespace dn::apps {

/// Returns true if the flight has point clouds, but none of the pair files it names exists.
bool HasStripsAlone(const FlightConfig& config);

/// Matches the strips of such a flight, stages the files that `dn match` writes, and calls
/// `calibrate` with the flight and its pairs. If the flight has no trajectory, the smoothed one is
/// staged as smoothed/trajectory.out.
void CalibrateStrips(const FlightConfig& config, const std::string& trajectory, Run& run,
                     const std::function<void(const FlightConfig&)>& calibrate);

/// Smooths the trajectory of a flight from its inertial and GNSS data, stages it in smoothed/, and
/// calls `calibrate` with the flight on this trajectory.
void CalibrateSmoothed(const FlightConfig& config, Run& run,
                       const std::function<void(const FlightConfig&)>& calibrate);

}  // namespace dn::apps
