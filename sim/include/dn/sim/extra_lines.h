#pragma once

#include <dn/sim/scenario.h>

#include <vector>

namespace dn {

/// A line across the others, through their middle, as long, high and fast as the first. `lines` must
/// not be empty.
PlannedLine CrossLine(const std::vector<PlannedLine>& lines);

/// The other way.
PlannedLine Reversed(PlannedLine line);

/// Higher by 40 % of the height above ground.
PlannedLine Higher(PlannedLine line, double height_above_ground_m);

/// Faster by 30 %.
PlannedLine Faster(PlannedLine line);

}  // namespace dn
