#pragma once

#include <dn/files/flight_config.h>
#include <dn/lidar/pairs.h>
#include <dn/sim/scenario.h>
#include <dn/sim/terrain.h>
#include <dn/sim/truth.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "active_effects.h"

namespace dn {

/// Options of SimulatePairs.
struct PairSimulation {
  std::uint64_t seed = 1;
  bool noise = true;
  std::function<void(double fraction)> progress;
};

/// Simulates correspondences that are distributed uniformly over the overlaps of all strip pairs,
/// `count` in total. The files "lidar/<a>_<b>.txt" are sorted by name, and the pairs in a file by
/// t_i. Throws InvalidConfig if no two strips overlap.
PairData SimulatePairs(const Scenario& scenario, const std::vector<StripInterval>& strips,
                       const std::shared_ptr<const TruthTrajectory>& truth,
                       const std::shared_ptr<const Terrain>& terrain, const PairSimulation& options,
                       const ActiveEffects& effects);

}  // namespace dn
