#pragma once

#include <dn/flight/map_gnss.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <cstdint>

#include "active_effects.h"

namespace dn {

/// Sigma of simulated GNSS velocities, east, north, up, m/s.
inline const Eigen::Vector3d kGnssVelocitySigma_enu_mps(0.02, 0.02, 0.03);

/// Antenna positions (and velocities where the scenario wants them) at whole multiples of 1 / rate
/// in GPS time, with the GNSS effects; without `noise` there is no white noise. Throws
/// InvalidConfig when no epoch is left, or a clock steps back over an epoch.
MapGnss SimulateGnss(const GnssScenario& gnss, const TruthTrajectory& truth, std::uint64_t seed,
                     bool noise, const ActiveEffects& effects);

}  // namespace dn
