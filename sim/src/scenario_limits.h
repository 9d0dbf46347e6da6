#pragma once

#include <dn/error.h>
#include <dn/sim/scenario.h>

#include <functional>
#include <string>

namespace dn {

/// Where a key of a section stands in the scenario's file.
using PlaceOfKey = std::function<FileLocation(const std::string& section, const std::string& key)>;

/// Throws InvalidConfig, naming the bound and the place, for a scenario that no memory holds or
/// that no flight comes near.
void CheckLimits(const Scenario& scenario, const PlaceOfKey& place);

/// The same once it is known how long the flight takes.
void CheckDuration(double duration_s);
void CheckPulses(const LidarScenario& lidar, double strips_s);
void CheckSamples(const ImuScenario& imu, double duration_s);

}  // namespace dn
