#pragma once

#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/imu_rows.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "active_effects.h"

namespace dn {

/// Simulated inertial data with their true values.
struct SimulatedImu {
  ImuData data;
  std::vector<Eigen::Vector3d> gyro_bias_radps;  ///< for every sample, mean over its interval
  std::vector<Eigen::Vector3d> accel_bias_mps2;
  std::vector<ImuRow> rows;  ///< rows of the file if they are point samples; else empty
  /// The truth at the beginning, and at the end of every interval.
  std::vector<NavPoint> reference;
};

/// Options of SimulateImu.
struct ImuSimulation {
  std::uint64_t seed = 1;
  bool noise = true;
  std::function<void(double fraction)> progress;
};

/// Returns the rows of a file whose reading gives these data, as means over their intervals.
std::vector<ImuRow> ImuRows(const ImuData& imu);

/// Simulates rates and specific forces, as means over (t_{k-1}, t_k] or at t_k, with t_k = begin +
/// k / rate. The noise of the model and the effects of the scenario apply.
SimulatedImu SimulateImu(const Scenario& scenario, const TruthTrajectory& truth,
                         const ImuSimulation& options, const ActiveEffects& effects);

}  // namespace dn
