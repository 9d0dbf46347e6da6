#include <algorithm>

#include "effects.h"

namespace dn {
namespace {

constexpr const char* kSensor =
    "take it from the data sheet or a laboratory calibration and correct imu.file, or estimate it";
constexpr const char* kAxes =
    "check imu.R_imu_to_body and the axes of imu.file; correct imu.file, or estimate it";
constexpr const char* kGravity =
    "gravity differs from normal gravity there; estimate it, or give the accelerometers a bias "
    "process large enough to cover it";
constexpr const char* kRanges =
    "correct the ranges of the pair files (lidar.p2p) and their unit, or estimate it";
constexpr const char* kMount =
    "the scanner moves relative to the inertial unit: fix its mount, or estimate it";

}  // namespace

const std::vector<EstimableEffect>& EstimableEffects() {
  using namespace internal;
  static const std::vector<EstimableEffect> effects{
      {"accel_scale_factor", "accelerometer scale factor", kSensor, AccelScaleFactor},
      {"accel_misalignment", "accelerometer misalignment", kAxes, AccelMisalignment},
      {"gyro_g_sensitivity", "gyro g-sensitivity", kSensor, GyroGSensitivity},
      {"gyro_scale_factor", "gyro scale factor", "estimate gyro_scale_factor", GyroScaleFactor},
      {"gyro_misalignment", "gyro misalignment", kAxes, GyroMisalignment},
      {"gravity_tilt", "deflection of gravity", kGravity, GravityTilt},
      {"gravity_disturbance", "gravity disturbance", kGravity, GravityDisturbance},
      {"gnss_lever_arm", "GNSS lever arm",
       "check the sign, axes and unit of gnss.lever_arm_m, or estimate gnss_lever_arm", nullptr},
      {"gnss_time_offset", "GNSS time offset",
       "check the time system of gnss.file against that of imu.file and correct its time tags, or "
       "estimate gnss_time_offset",
       GnssTimeOffset},
      {"gnss_time_drift", "GNSS time drift",
       "the clocks of gnss.file and imu.file drift apart: correct the time tags, or estimate "
       "gnss_time_offset and gnss_time_drift",
       GnssTimeDrift},
      {"gnss_position_step", "step of the GNSS positions",
       "leave out the epochs of the window, or estimate it", GnssPositionStep},
      {"lidar_time_offset", "lidar time offset",
       "check the time tags of the pair files against those of imu.file, or estimate "
       "lidar_time_offset",
       nullptr},
      {"lidar_time_drift", "lidar time drift",
       "the clock of the scanner drifts: correct the time tags of the pair files, or estimate it",
       LidarTimeDrift},
      {"lidar_lever_arm", "lidar lever arm",
       "check the sign, axes and unit of lidar.lever_arm_m, or estimate lidar_lever_arm", nullptr},
      {"lidar_range_offset", "lidar range offset", kRanges, LidarRangeOffset},
      {"lidar_range_scale", "lidar range scale", kRanges, LidarRangeScale},
      {"lidar_angle_scale", "lidar angle scale",
       "correct the scan angles of the laser vectors in the pair files (lidar.p2p), or estimate it",
       LidarAngleScale},
      {"lidar_scan_cone", "lidar scan cone",
       "the beam leaves the scan plane: correct the laser vectors in the pair files (lidar.p2p), "
       "or estimate it",
       LidarScanCone},
      {"boresight_drift", "boresight drift", kMount, BoresightDrift},
      {"boresight_step", "boresight step", kMount, BoresightStep},
  };
  return effects;
}

const EstimableEffect* FindEstimable(std::string_view name) {
  const std::vector<EstimableEffect>& all = EstimableEffects();
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const auto& effect) { return name == effect.name; });
  return at == all.end() ? nullptr : &*at;
}

}  // namespace dn
