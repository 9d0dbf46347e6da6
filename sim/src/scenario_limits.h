#pragma once

#include <dn/error.h>
#include <dn/sim/scenario.h>

#include <functional>
#include <string>

namespace dn {

/// Function that returns the location of a key of a section in the file of the scenario.
using KeyLocator = std::function<FileLocation(const std::string& section, const std::string& key)>;

/// Throws InvalidConfig, with limit and location, for a scenario that does not fit into memory or
/// that is far from any real flight.
void CheckLimits(const Scenario& scenario, const KeyLocator& place);

/// Checks the limits that depend on the duration of the flight; throws as CheckLimits does.
void CheckDuration(double duration_s);
void CheckPulses(const LidarScenario& lidar, double strips_s);
void CheckSamples(const ImuScenario& imu, double duration_s);

}  // namespace dn
