#pragma once

#include <dn/effects/unmodelled_prior.h>
#include <dn/sim/scenario.h>

#include <cstdint>
#include <vector>

namespace dn {

/// Draws every effect that has a prior from it: each component is normal, with `factor` times the
/// standard deviation of the prior. The values are in the units of EffectTable.
std::vector<Effect> DrawEffects(const UnmodelledPrior& prior, double factor, std::uint64_t seed);

}  // namespace dn
