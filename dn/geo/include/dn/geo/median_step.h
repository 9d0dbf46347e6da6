#pragma once

#include <dn/geo/trajectory.h>

#include <vector>

namespace dn {

/// Returns the median time between consecutive points, s. Needs at least two points.
double MedianStep(const std::vector<NavPoint>& points);

}  // namespace dn
