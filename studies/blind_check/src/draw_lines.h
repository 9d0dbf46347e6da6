#pragma once

#include <dn/sim/random.h>
#include <dn/sim/scenario.h>

namespace dn {

/// Changes the lines of a plan at random: length, common rotation, height, number and, in some
/// plans, an additional cross strip. base_m: height of the ground, m.
void DrawLines(double base_m, Random& random, PlanScenario* plan);

}  // namespace dn
