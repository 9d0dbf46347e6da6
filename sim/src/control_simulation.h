#pragma once

#include <dn/files/control.h>
#include <dn/files/flight_config.h>
#include <dn/sim/scenario.h>
#include <dn/sim/terrain.h>
#include <dn/sim/truth.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "active_effects.h"

namespace dn {

/// Options of SimulateControl.
struct ControlSimulation {
  std::uint64_t seed = 1;
  bool noise = true;
  LidarSpan span;  ///< true lidar epochs to which the effects refer
};

/// Simulates surveyed points on the ground that the strips pass, each with one laser return. A
/// return has the noise of one end of a pair. The corners are peaks of gables whose roof and wall
/// the strips see; they have no laser return. Throws InvalidConfig if the strips see no ground or
/// too few gables.
ControlData SimulateControl(const Scenario& scenario, const std::vector<StripInterval>& strips,
                            const std::shared_ptr<const TruthTrajectory>& truth,
                            const std::shared_ptr<const Terrain>& terrain,
                            const ControlSimulation& options, const ActiveEffects& effects);

}  // namespace dn
