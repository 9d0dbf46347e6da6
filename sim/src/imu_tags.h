#pragma once

#include "active_effects.h"
#include "imu_simulation.h"

namespace dn {

/// Removes the samples inside gaps, with their biases, and shifts the time tags; the intervals are
/// then those that a reader finds. Throws InvalidConfig if no sample remains, or if the clock steps
/// back beyond a sample.
void ApplyImuTagEffects(const ActiveEffects& effects, SimulatedImu* imu);

}  // namespace dn
