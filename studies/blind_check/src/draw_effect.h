#pragma once

#include <dn/effects/effect_table.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>

namespace dn {

/// The effects of the table that a diagnosis may be asked for: all but the faults.
std::vector<const EffectSpec*> DiagnosableEffects();

/// An entry of `effects:` with random sizes, signs, axes and times.
Effect DrawEffect(const EffectSpec& effect, const FlightTimes& times, Random& random);

}  // namespace dn
