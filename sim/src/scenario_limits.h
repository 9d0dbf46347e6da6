#pragma once

#include <dn/sim/scenario.h>

namespace dn {

/// Throws InvalidConfig, naming the bound, for a scenario that no memory holds or that no flight
/// comes near.
void CheckLimits(const Scenario& scenario);

/// The same once it is known how long the flight takes.
void CheckDuration(double duration_s);
void CheckSamples(const ImuScenario& imu, double duration_s);

}  // namespace dn
