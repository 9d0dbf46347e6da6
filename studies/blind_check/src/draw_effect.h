#pragma once

#include <dn/effects/effect_table.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>

namespace dn {

/// Returns the effects of the table that a diagnosis can name: all except the faults.
std::vector<const EffectSpec*> DiagnosableEffects();

/// Draws an entry of `effects` with random sizes, signs, axes and times. The sizes are those of
/// DrawBlindFlight times `size_factor`.
Effect DrawEffect(const EffectSpec& effect, double size_factor, const FlightTimes& times,
                  Random& random);

}  // namespace dn
