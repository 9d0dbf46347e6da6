#pragma once

#include <vector>

namespace dn::matching_internal {

/// Fills cells without a height (NaN) of a grid with nx columns. First, cells with at least five
/// neighbours that have a height get their median. Then up to `passes` rounds from the rim inwards
/// fill cells with at least three such neighbours; these get the lowest of them. The ground hidden
/// behind a roof is as low as its surroundings. Without the second step, moving a roof toward its
/// own shadow would not increase the height differences.
void FillVoids(int nx, int ny, int passes, std::vector<float>* z_m);

}  // namespace dn::matching_internal
