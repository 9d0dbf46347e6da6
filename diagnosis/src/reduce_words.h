#pragma once

#include <dn/effects/effect_table.h>

#include <string>

namespace dn::diagnosis_internal {

/// Returns what would reduce the uncertainty that an effect outside of the model leaves: a
/// measurement or a document, whose figure belongs under `unmodelled`, or a line to fly.
std::string ReduceWords(EffectId effect);

}  // namespace dn::diagnosis_internal
