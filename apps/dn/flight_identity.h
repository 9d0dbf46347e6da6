#pragma once

#include <dn/files/flight_config.h>
#include <dn/fleet/reduced_flight.h>

#include <string>
#include <vector>

namespace dn::apps {

/// Sets the hashes that identify a reduced flight: that of its data files, and that of version,
/// configuration and data. The section `across` does not count. `changes`: --set values, as in
/// ReadFlightConfig.
void SetIdentity(const FlightConfig& config, const std::vector<std::string>& changes,
                 ReducedFlight* flight);

}  // namespace dn::apps
