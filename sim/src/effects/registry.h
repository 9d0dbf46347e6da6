#pragma once

#include <dn/sim/random.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "active_effects.h"

namespace dn {

/// One entry of `effects:` as its physics gets it.
struct EffectInput {
  const Scenario& scenario;
  const Effect& entry;
  Eigen::VectorXd value;  ///< SI, in the order of the table
  std::uint64_t seed;
  std::string stream;  ///< of random numbers, the entry's own

  Random MakeRandom() const { return {seed, stream}; }
};

/// Puts the physics of one entry into the lists.
using ActivateEffect = void (*)(const EffectInput& input, ActiveEffects* active);

struct SimulatedEffect {
  const char* name;
  ActivateEffect activate;
};

/// The physics of every effect of EffectTable, in the order in which they apply: sensor errors as
/// misalignment, scale, g-sensitivity; laser vectors as cone, angle, range.
const std::vector<SimulatedEffect>& SimulatedEffects();

}  // namespace dn
