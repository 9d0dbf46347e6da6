#pragma once

#include <dn/files/flight_config.h>
#include <dn/lidar/pairs.h>
#include <dn/sim/scenario.h>
#include <dn/sim/terrain.h>
#include <dn/sim/truth.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "active_effects.h"

namespace dn {

/// Options of SimulatePairs.
struct PairSimulation {
  std::uint64_t seed = 1;
  bool noise = true;
  std::function<void(double fraction)> progress;
  std::string folder = "lidar";  ///< of the pair files
};

/// One of the two scanners that measure pairs; both references must outlive the simulation.
struct PairSide {
  const Scenario& scenario;  ///< with this scanner alone
  const ActiveEffects& effects;
};

/// Simulates correspondences that are distributed uniformly over the overlaps of all strip pairs,
/// `count` in total. The files "lidar/<a>_<b>.txt" are sorted by name, and the pairs in a file by
/// t_i. Throws InvalidConfig if no two strips overlap.
PairData SimulatePairs(const Scenario& scenario, const std::vector<StripInterval>& strips,
                       const std::shared_ptr<const TruthTrajectory>& truth,
                       const std::shared_ptr<const Terrain>& terrain, const PairSimulation& options,
                       const ActiveEffects& effects);

/// Simulates `between` correspondences whose first end one scanner measures, and another the
/// second, in the same way. They are in the overlaps of all strips. A strip overlaps with itself
/// where the two scanners see a point at least half a second apart.
PairData SimulatePairsBetween(const PairSide& i, const PairSide& j,
                              const std::vector<StripInterval>& strips,
                              const std::shared_ptr<const TruthTrajectory>& truth,
                              const std::shared_ptr<const Terrain>& terrain,
                              const PairSimulation& options);

}  // namespace dn
