#pragma once

#include <vector>

#include "effect_screen.h"

namespace dn::internal {

/// What could be there in its usual size without being seen, the most harmful first; of several
/// candidates of one name the one that does most. `score`: of the candidates, in their order, with
/// the coordinates of the options in its shift.
std::vector<UnseenEffect> FindUnseen(const std::vector<CandidateEffect>& candidates,
                                     const JointScore& score, const ScreenOptions& options);

}  // namespace dn::internal
