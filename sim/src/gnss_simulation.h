#pragma once

#include <dn/files/map_gnss.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <cstdint>

#include "active_effects.h"

namespace dn {

/// Standard deviation of simulated GNSS velocities, east, north, up, m/s.
inline const Eigen::Vector3d kGnssVelocitySigma_enu_mps(0.02, 0.02, 0.03);

/// Simulates antenna positions, and velocities if the scenario has them, at multiples of 1 / rate
/// in GPS time. The GNSS effects apply; without `noise` there is no white noise. Throws
/// InvalidConfig if no epoch remains, or if a clock steps back beyond an epoch.
MapGnss SimulateGnss(const GnssScenario& gnss, const TruthTrajectory& truth, std::uint64_t seed,
                     bool noise, const ActiveEffects& effects);

}  // namespace dn
