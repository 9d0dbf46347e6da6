#pragma once

#include <dn/effects/effect_table.h>
#include <dn/sim/random.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "active_effects.h"

namespace dn {

/// Input of the physics of one entry of `effects:`.
struct EffectInput {
  const Scenario& scenario;
  const Effect& entry;
  Eigen::VectorXd value;  ///< SI, in the order of the table
  std::uint64_t seed;
  std::string stream;  ///< name of the random number stream, unique for the entry

  Random MakeRandom() const { return {seed, stream}; }
};

/// Adds the physics of one entry to the lists of `active`.
using ActivateEffect = void (*)(const EffectInput& input, ActiveEffects* active);

/// An effect and the function with its physics.
struct SimulatedEffect {
  EffectId id;
  ActivateEffect activate;
};

/// Returns the physics of every effect of EffectTable, in the order in which they apply. Sensor
/// errors: misalignment, scale factor, g-sensitivity. Laser vectors: cone, angle, range.
const std::vector<SimulatedEffect>& SimulatedEffects();

}  // namespace dn
