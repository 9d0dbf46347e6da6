#pragma once

#include <dn/effects/effect_table.h>

#include <string>

namespace dn::diagnosis_internal {

/// Returns what would reduce the uncertainty that an effect outside of the model leaves. It is a
/// line to fly, or a measurement or document whose figure belongs under `unmodelled`.
std::string ReduceWords(EffectId effect);

}  // namespace dn::diagnosis_internal
