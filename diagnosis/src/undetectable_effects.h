#pragma once

#include <vector>

#include "effect_screen.h"

namespace dn::internal {

/// Returns the undetectable effects: they would be harmful at their typical size, but are below
/// their minimal detectable bias. The largest shift comes first; among candidates of one name only
/// the one with the largest shift counts. `score` is that of the candidates, in their order, with
/// the coordinates of the options in its shift.
std::vector<UndetectableEffect> FindUndetectable(const std::vector<CandidateEffect>& candidates,
                                                 const JointScore& score,
                                                 const ScreenOptions& options);

}  // namespace dn::internal
