#pragma once

#include <dn/files/strip_at.h>
#include <dn/sim/simulate.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <tuple>

namespace dn::diagnosis_test {

/// Adds errors to the pairs of a flight that pairs of two strips within a tile of the ground share.
/// `share` is their variance over the stated one of a pair.
inline void SharePairErrors(double share, double tile_m, std::uint64_t seed, SimulatedFlight* sim) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const LidarConfig& lidar = *sim->flight.config.lidar;
  const double sigma_m = std::sqrt(share) * lidar.sigma_p_m;
  const std::vector<StripInterval> strips = FindStrips(sim->flight);
  std::map<std::tuple<std::string, long, long>, Eigen::Vector3d> error_m;
  for (LidarPair& pair : sim->flight.pairs->pairs) {
    const MapPose pose = sim->truth->Pose(pair.t_i_s);
    const Eigen::Matrix3d R_ms = pose.q_mb.toRotationMatrix() * lidar.mounting.R_bs_nominal;
    const Eigen::Vector3d ground_m = pose.p_mb + R_ms * pair.u_i_s;
    const auto number = [&](double x_m) { return std::lround(std::floor(x_m / tile_m)); };
    const auto [at, is_new] = error_m.try_emplace(
        {StripPairName(strips, pair.t_i_s, pair.t_j_s), number(ground_m.x()), number(ground_m.y())},
        Eigen::Vector3d::Zero());
    if (is_new) {
      for (double& e : at->second) e = sigma_m * normal(random);
    }
    pair.u_i_s += R_ms.transpose() * at->second;
  }
}

}  // namespace dn::diagnosis_test
