#pragma once

#include <dn/calibration/pair_residuals.h>
#include <dn/flight/flight_config.h>
#include <dn/lidar/swath.h>

#include <string>
#include <vector>

namespace dn {

/// Of each strip the path of the poses, and beside it the ground as far to the left and to the
/// right as the pairs of the strip reach: no outline where it has none.
std::vector<Swath> SwathsOfPairs(const std::vector<StripInterval>& strips,
                                 const std::vector<PairResidual>& pairs,
                                 const PoseInterpolator& poses);

/// swaths.json: per strip `strip`, `line_en_m`, `outline_en_m`, to the centimetre.
std::string FormatSwaths(const std::vector<Swath>& swaths);

}  // namespace dn
