#pragma once

#include <dn/gnss/gnss_data.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <cstdint>

namespace dn {

/// Sigma of simulated GNSS velocities, east, north, up, m/s.
inline const Eigen::Vector3d kGnssVelocitySigma_enu_mps(0.02, 0.02, 0.03);

/// Antenna positions (and velocities where the scenario wants them) at whole multiples of 1 / rate
/// in GPS time; lever_arm_b_m is the true one, noise_scale the ratio of the actual white noise to
/// the stated sigmas (0: none).
GnssData SimulateGnss(const GnssScenario& gnss, const Eigen::Vector3d& lever_arm_b_m,
                      const TruthTrajectory& truth, std::uint64_t seed, double noise_scale);

}  // namespace dn
