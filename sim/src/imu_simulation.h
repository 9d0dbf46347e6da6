#pragma once

#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "active_effects.h"

namespace dn {

struct SimulatedImu {
  ImuData data;
  std::vector<Eigen::Vector3d> gyro_bias_radps;  ///< of every sample, mean over its interval
  std::vector<Eigen::Vector3d> accel_bias_mps2;
  std::vector<NavPoint> reference;  ///< the truth at the begin, and at the end of every interval
};

struct ImuSimulation {
  std::uint64_t seed = 1;
  bool noise = true;
  std::function<void(double fraction)> progress;
};

/// Means of rate and specific force over (t_{k-1}, t_k], t_k = begin + k / rate, with the model's
/// noise and the scenario's effects.
SimulatedImu SimulateImu(const Scenario& scenario, const TruthTrajectory& truth,
                         const ImuSimulation& options, const ActiveEffects& effects);

}  // namespace dn
