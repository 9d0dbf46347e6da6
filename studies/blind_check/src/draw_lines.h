#pragma once

#include <dn/sim/random.h>
#include <dn/sim/scenario.h>

namespace dn {

/// Changes the lines of a plan: shorter, turned together, higher or lower, fewer of them, and for
/// some a cross strip. base_m: height of the ground.
void DrawLines(double base_m, Random& random, PlanScenario* plan);

}  // namespace dn
