#pragma once

#include <dn/report/json.h>
#include <dn/sim/random.h>

#include <vector>

namespace dn {

/// Draws a random walk from zero: its values after 0, 1, ... steps, as a JSON list.
Json DrawRandomWalk(int steps, double step_sigma, Random& random);

/// Returns the walk after a number of steps, linear between the values and constant outside them.
/// There are at least two values.
double RandomWalkAt(const std::vector<double>& values, double steps);

}  // namespace dn
