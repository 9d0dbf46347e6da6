#include "effects.h"

namespace dn {

const std::vector<EffectDescription>& KnownEffects() {
  static const std::vector<EffectDescription> effects{
      {"gnss_lever_arm", 3, true},         {"gnss_time_offset", 1, false},
      {"gnss_correlated_noise", 4, false}, {"gnss_position_step", 3, false},
      {"gnss_noise_scale", 1, false},      {"gyro_scale_factor", 3, true},
      {"accel_scale_factor", 3, false},    {"gyro_misalignment", 3, false},
      {"accel_misalignment", 3, false},    {"gyro_g_sensitivity", 3, false},
      {"gyro_bias_process", 2, false},     {"accel_bias_process", 2, false},
      {"gyro_noise_scale", 1, false},      {"accel_noise_scale", 1, false},
      {"imu_vibration", 2, false},         {"gravity_tilt", 2, false},
      {"gravity_disturbance", 1, false},   {"lidar_lever_arm", 3, true},
      {"lidar_time_offset", 1, true},      {"lidar_time_drift", 1, false},
      {"lidar_range_offset", 1, false},    {"lidar_range_scale", 1, false},
      {"lidar_angle_scale", 1, false},     {"lidar_scan_cone", 1, false},
      {"boresight_drift", 3, false},       {"boresight_step", 3, false},
      {"p2p_noise_scale", 1, false},       {"p2p_outliers", 2, false},
      {"p2p_range_noise", 1, false},       {"trajectory_attitude_offset", 3, false},
  };
  return effects;
}

std::vector<std::string> SimulatedEffects() {
  std::vector<std::string> names;
  for (const EffectDescription& effect : KnownEffects()) {
    if (effect.simulated) names.push_back(effect.name);
  }
  return names;
}

Eigen::Vector3d VectorEffect(const Scenario& scenario, const std::string& name) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Effect& effect : scenario.effects) {
    if (effect.name == name)
      sum += Eigen::Vector3d(effect.value[0], effect.value[1], effect.value[2]);
  }
  return sum;
}

double ScalarEffect(const Scenario& scenario, const std::string& name) {
  double sum = 0.0;
  for (const Effect& effect : scenario.effects) {
    if (effect.name == name) sum += effect.value[0];
  }
  return sum;
}

}  // namespace dn
