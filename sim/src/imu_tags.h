#pragma once

#include "active_effects.h"
#include "imu_simulation.h"

namespace dn {

/// Takes out the rows inside gaps and shifts the tags, as a reader then finds the data; the biases
/// go with their samples. Throws InvalidConfig when no sample is left, or the clock steps back over
/// a sample.
void ApplyImuTagEffects(const ActiveEffects& effects, SimulatedImu* imu);

}  // namespace dn
