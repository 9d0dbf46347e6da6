#pragma once

#include <dn/matching/match.h>
#include <dn/report/json.h>

namespace dn::matching_internal {

/// Returns the shift between two strips (p_i - p_j with the initial alignment, at the centre of the
/// pairs) and its sigma. Also returns the scatter of the pairs about a plane over east and north.
/// Returns null for fewer than four pairs.
Json OffsetJson(const StripPairMatch& match);

/// Returns the closure of each loop of three strips. It is the sum of the shifts i - j, j - k and k
/// - i at one place. It is zero, within its sigma, if the shifts are those of rigid strips.
Json LoopsJson(const MatchResult& result, const MatchSource& source);

}  // namespace dn::matching_internal
