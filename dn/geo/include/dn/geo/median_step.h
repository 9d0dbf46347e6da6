#pragma once

#include <dn/geo/trajectory.h>

#include <vector>

namespace dn {

/// Median of the time between one point and the next, s; of two points or more.
double MedianStep(const std::vector<NavPoint>& points);

}  // namespace dn
