#pragma once

#include <dn/flight/flight_config.h>

#include <string>

namespace dn::apps {

/// The configuration of a flight with the trajectory of the command line; empty: its own.
FlightConfig WithTrajectory(FlightConfig config, const std::string& trajectory);

/// Whether there is a trajectory for ReadFlight to read.
bool HasTrajectory(const FlightConfig& config);

}  // namespace dn::apps
