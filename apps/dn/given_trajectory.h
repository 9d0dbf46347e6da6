#pragma once

#include <dn/files/flight_config.h>

#include <string>

namespace dn::apps {

/// Returns the configuration with the trajectory file replaced by `trajectory`, unless that is
/// empty.
FlightConfig WithTrajectory(FlightConfig config, const std::string& trajectory);

/// Returns true if the trajectory file that ReadFlight would read exists.
bool HasTrajectory(const FlightConfig& config);

}  // namespace dn::apps
