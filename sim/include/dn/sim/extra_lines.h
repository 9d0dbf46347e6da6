#pragma once

#include <dn/sim/scenario.h>

#include <vector>

namespace dn {

/// Returns a line across the others, through their centre, with the length, height and speed of the
/// first line. `lines` must not be empty.
PlannedLine CrossLine(const std::vector<PlannedLine>& lines);

/// Returns the line flown in the opposite direction.
PlannedLine Reversed(PlannedLine line);

/// Returns the line raised by 40 % of the height above ground.
PlannedLine Higher(PlannedLine line, double height_above_ground_m);

/// Returns the line with a speed 30 % higher.
PlannedLine Faster(PlannedLine line);

}  // namespace dn
