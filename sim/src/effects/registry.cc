#include "effects/registry.h"

#include "effects/physics.h"

namespace dn {

const std::vector<SimulatedEffect>& SimulatedEffects() {
  static const std::vector<SimulatedEffect> effects{
      {"gyro_misalignment", &effects::GyroMisalignment},
      {"accel_misalignment", &effects::AccelMisalignment},
      {"gyro_scale_factor", &effects::GyroScaleFactor},
      {"accel_scale_factor", &effects::AccelScaleFactor},
      {"gyro_g_sensitivity", &effects::GyroGSensitivity},
      {"gravity_tilt", &effects::GravityTilt},
      {"gravity_disturbance", &effects::GravityDisturbance},
      {"gyro_bias_process", &effects::GyroBiasProcess},
      {"accel_bias_process", &effects::AccelBiasProcess},
      {"gyro_noise_scale", &effects::GyroNoiseScale},
      {"accel_noise_scale", &effects::AccelNoiseScale},
      {"imu_vibration", &effects::ImuVibration},
      {"imu_gap", &effects::ImuGap},
      {"imu_clock_step", &effects::ImuClockStep},
      {"gnss_lever_arm", &effects::GnssLeverArm},
      {"gnss_noise_scale", &effects::GnssNoiseScale},
      {"gnss_position_step", &effects::GnssPositionStep},
      {"gnss_correlated_noise", &effects::GnssCorrelatedNoise},
      {"gnss_outliers", &effects::GnssOutliers},
      {"gnss_outage", &effects::GnssOutage},
      {"gnss_time_offset", &effects::GnssTimeOffset},
      {"gnss_time_drift", &effects::GnssTimeDrift},
      {"gnss_clock_step", &effects::GnssClockStep},
      {"lidar_lever_arm", &effects::LidarLeverArm},
      {"boresight_drift", &effects::BoresightDrift},
      {"boresight_step", &effects::BoresightStep},
      {"lidar_scan_cone", &effects::LidarScanCone},
      {"lidar_angle_scale", &effects::LidarAngleScale},
      {"lidar_range_scale", &effects::LidarRangeScale},
      {"lidar_range_offset", &effects::LidarRangeOffset},
      {"lidar_time_offset", &effects::LidarTimeOffset},
      {"lidar_time_drift", &effects::LidarTimeDrift},
      {"p2p_range_noise", &effects::P2pRangeNoise},
      {"p2p_noise_scale", &effects::P2pNoiseScale},
      {"p2p_outliers", &effects::P2pOutliers},
      {"trajectory_attitude_offset", &effects::TrajectoryAttitudeOffset},
  };
  return effects;
}

}  // namespace dn
