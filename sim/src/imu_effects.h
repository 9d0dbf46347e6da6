#pragma once

#include <dn/sim/random.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "imu_simulation.h"

namespace dn {

/// What the scenario's effects do to the inertial sensors beyond the assumed model, in the order
/// misalignment, scale, g-sensitivity; bias and noise follow elsewhere.
class ImuEffects {
 public:
  ImuEffects(const Scenario& scenario, std::uint64_t seed);

  /// Specific force with the actual gravity instead of the normal one (gravity_tilt,
  /// gravity_disturbance).
  Eigen::Vector3d ActualForce(const TruthState& state, const LocalFrame& frame) const;

  /// Errors of the triads, on the mean true rate and force of a sample.
  void Distort(ImuSample* sample) const;

  /// Vibration, white per sample, inside its windows.
  void Shake(ImuSample* sample);

  double gyro_noise_ratio() const { return gyro_noise_ratio_; }
  double accel_noise_ratio() const { return accel_noise_ratio_; }
  /// Bias processes beyond the assumed ones.
  const std::vector<BiasProcess>& gyro_processes() const { return gyro_processes_; }
  const std::vector<BiasProcess>& accel_processes() const { return accel_processes_; }

 private:
  Eigen::Matrix3d gyro_turn_, accel_turn_;    // of the triads: measured = turn true
  Eigen::Vector3d gyro_scale_, accel_scale_;  // 1
  Eigen::Vector3d g_sensitivity_;             // rad/s per m/s^2
  Eigen::Vector3d gravity_enu_;               // direction, in g: east, north
  double gravity_disturbance_mps2_ = 0.0;
  double gyro_noise_ratio_ = 1.0, accel_noise_ratio_ = 1.0;
  std::vector<BiasProcess> gyro_processes_, accel_processes_;
  std::vector<Effect> vibrations_;
  Random random_;
};

/// Takes out the rows inside imu_gap windows and shifts the tags by imu_clock_step, as a reader
/// then finds the data; the biases go with their samples. Throws InvalidConfig when no sample is
/// left, or the clock steps back over a sample.
void ApplyImuTagEffects(const Scenario& scenario, SimulatedImu* imu);

}  // namespace dn
