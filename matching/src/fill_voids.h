#pragma once

#include <vector>

namespace dn::internal {

/// Fills cells without a height (NaN) of a grid with nx columns: where at least five neighbours have
/// one, with their median; then, in up to `passes` rounds from the rim inwards, with the lowest of
/// at least three neighbours: what the scanner does not see behind a roof is as low as what lies
/// beside it. Without the second step a roof moved toward its own shadow would cost nothing.
void FillVoids(int nx, int ny, int passes, std::vector<float>* z_m);

}  // namespace dn::internal
