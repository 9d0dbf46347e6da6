#pragma once

#include <dn/adjustment/pair_residuals.h>
#include <dn/files/flight_config.h>
#include <dn/lidar/swath.h>

#include <string>
#include <vector>

namespace dn {

/// Returns for each strip the line of the poses, and the outline of the ground that its pairs cover
/// to the left and right. The outline is empty if the strip has no pairs.
std::vector<Swath> MakeSwaths(const std::vector<StripInterval>& strips,
                              const std::vector<PairResidual>& pairs,
                              const PoseInterpolator& poses);

/// Returns the text of swaths.json: per strip `strip`, `line_en_m`, `outline_en_m`, rounded to 1
/// cm.
std::string FormatSwaths(const std::vector<Swath>& swaths);

}  // namespace dn
