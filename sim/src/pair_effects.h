#pragma once

#include <dn/lidar/pairs.h>
#include <dn/sim/scenario.h>

#include <cstdint>

namespace dn {

/// Ratio of the actual noise of a pair to the assumed one: p2p_noise_scale, and p2p_range_noise at
/// the pair's mean range.
double PairNoiseRatio(const Scenario& scenario, double mean_range_m);

/// What the scanner makes of a true vector in its frame: errors of scan angle and range.
Eigen::Vector3d Distort(const Scenario& scenario, const Eigen::Vector3d& u_s_m);

/// Puts wrong pairs and the drift of the time tags into finished pairs. Without `noise` there are
/// no wrong pairs.
void ApplyPairEffects(const Scenario& scenario, std::uint64_t seed, bool noise, PairData* data);

}  // namespace dn
