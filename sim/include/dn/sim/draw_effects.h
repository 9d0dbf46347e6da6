#pragma once

#include <dn/effects/unmodelled_prior.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace dn {

/// Draws every effect that has a prior from it: each component is normal, with `factor` times the
/// standard deviation of the prior. The values are in the units of EffectTable.
std::vector<Effect> DrawEffects(const UnmodelledPrior& prior, double factor, std::uint64_t seed);

/// Draws a time-correlated error of GNSS positions from GnssProcessPrior, with `factor` times its
/// size, for these stated sigmas east, north, up.
Effect DrawGnssProcess(const Eigen::Vector3d& stated_enu_m, double factor, std::uint64_t seed);

/// Draws the errors that neighbouring pairs share. Half of the flights have none. In the others,
/// the variance of these errors is 1/128, 1/64, .. 1 of that of the independent ones, times
/// `factor` squared. Their length is 15, 30, 60 or 120 m. All values are equally probable.
void DrawSharedPairErrors(double factor, std::uint64_t seed, PairScenario* pairs);

/// Returns the scenario with the draws of the three functions above. These are every effect of the
/// prior of its flights, a time-correlated error of GNSS positions, and shared errors of pairs. A
/// scenario with its own process or shared errors keeps them.
Scenario WithDrawnEffects(Scenario scenario, double factor, std::uint64_t seed);

}  // namespace dn
