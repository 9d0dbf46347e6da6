#include "effects.h"

namespace dn {

const std::vector<EffectDescription>& KnownEffects() {
  using Timing = EffectDescription::Timing;
  static const std::vector<EffectDescription> effects{
      {"gnss_lever_arm", 3, true},
      {"gnss_time_offset", 1, true},
      {"gnss_correlated_noise", 4, true},
      {"gnss_position_step", 3, true, Timing::kWindow},
      {"gnss_noise_scale", 1, true},
      {"gyro_scale_factor", 3, true},
      {"accel_scale_factor", 3, true},
      {"gyro_misalignment", 3, true},
      {"accel_misalignment", 3, true},
      {"gyro_g_sensitivity", 3, true},
      {"gyro_bias_process", 2, true},
      {"accel_bias_process", 2, true},
      {"gyro_noise_scale", 1, true},
      {"accel_noise_scale", 1, true},
      {"imu_vibration", 2, true, Timing::kWindow},
      {"gravity_tilt", 2, true},
      {"gravity_disturbance", 1, true},
      {"lidar_lever_arm", 3, true},
      {"lidar_time_offset", 1, true},
      {"lidar_time_drift", 1, true},
      {"lidar_range_offset", 1, true},
      {"lidar_range_scale", 1, true},
      {"lidar_angle_scale", 1, true},
      {"lidar_scan_cone", 1, false},
      {"boresight_drift", 3, false},
      {"boresight_step", 3, false, Timing::kStart},
      {"p2p_noise_scale", 1, true},
      {"p2p_outliers", 2, true},
      {"p2p_range_noise", 1, true},
      {"trajectory_attitude_offset", 3, true},
      {"gnss_outage", 0, true, Timing::kWindow},
      {"gnss_outliers", 2, true},
      {"gnss_clock_step", 1, true, Timing::kStart},
      {"imu_gap", 0, true, Timing::kWindow},
      {"imu_clock_step", 1, true, Timing::kStart},
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

std::vector<const Effect*> EffectsNamed(const Scenario& scenario, const std::string& name) {
  std::vector<const Effect*> effects;
  for (const Effect& effect : scenario.effects) {
    if (effect.name == name) effects.push_back(&effect);
  }
  return effects;
}

Eigen::Vector3d VectorEffect(const Scenario& scenario, const std::string& name) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Effect* effect : EffectsNamed(scenario, name)) {
    sum += Eigen::Vector3d(effect->value[0], effect->value[1], effect->value[2]);
  }
  return sum;
}

double ScalarEffect(const Scenario& scenario, const std::string& name) {
  double sum = 0.0;
  for (const Effect* effect : EffectsNamed(scenario, name)) sum += effect->value[0];
  return sum;
}

double RatioEffect(const Scenario& scenario, const std::string& name) {
  double ratio = 1.0;
  for (const Effect* effect : EffectsNamed(scenario, name)) ratio *= effect->value[0];
  return ratio;
}

}  // namespace dn
