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
  using namespace builder_internal;
  static const std::vector<EstimableEffect> effects{
      {EffectId::kAccelScaleFactor, "accelerometer scale factor", kSensor, AccelScaleFactor},
      {EffectId::kAccelMisalignment, "accelerometer misalignment", kAxes, AccelMisalignment},
      {EffectId::kGyroGSensitivity, "gyro g-sensitivity", kSensor, GyroGSensitivity},
      {EffectId::kGyroScaleFactor, "gyro scale factor", "estimate gyro_scale_factor",
       GyroScaleFactor},
      {EffectId::kGyroMisalignment, "gyro misalignment", kAxes, GyroMisalignment},
      {EffectId::kGravityTilt, "deflection of gravity", kGravity, GravityTilt},
      {EffectId::kGravityDisturbance, "gravity disturbance", kGravity, GravityDisturbance},
      {EffectId::kGnssLeverArm, "GNSS lever arm",
       "check the sign, axes and unit of gnss.lever_arm_m, or estimate gnss_lever_arm",
       GnssLeverArm, ConfiguredGnssLeverArm},
      {EffectId::kGnssTimeOffset, "GNSS time offset",
       "check the time system of gnss.file against that of imu.file and correct its time tags, or "
       "estimate gnss_time_offset",
       GnssTimeOffset},
      {EffectId::kGnssTimeDrift, "GNSS time drift",
       "the clocks of gnss.file and imu.file drift apart: correct the time tags, or estimate "
       "gnss_time_offset and gnss_time_drift",
       GnssTimeDrift},
      {EffectId::kGnssPositionStep, "step of the GNSS positions",
       "leave out the epochs of the window, or estimate it", GnssPositionStep},
      {EffectId::kLidarTimeOffset, "lidar time offset",
       "check the time tags of the pair files against those of imu.file, or estimate "
       "lidar_time_offset",
       LidarTimeOffset, ConfiguredLidarTimeOffset},
      {EffectId::kLidarTimeDrift, "lidar time drift",
       "the clock of the scanner drifts: correct the time tags of the pair files, or estimate it",
       LidarTimeDrift},
      {EffectId::kLidarLeverArm, "lidar lever arm",
       "check the sign, axes and unit of lidar.lever_arm_m, or estimate lidar_lever_arm",
       LidarLeverArm, ConfiguredLidarLeverArm},
      {EffectId::kLidarRangeOffset, "lidar range offset", kRanges, LidarRangeOffset},
      {EffectId::kLidarRangeScale, "lidar range scale", kRanges, LidarRangeScale},
      {EffectId::kLidarAngleScale, "lidar angle scale",
       "correct the scan angles of the laser vectors in the pair files (lidar.p2p), or estimate it",
       LidarAngleScale},
      {EffectId::kLidarScanTorsion, "lidar scan torsion",
       "the beam leaves the scan plane with the scan angle: correct the laser vectors in the pair "
       "files (lidar.p2p), or estimate it",
       LidarScanTorsion},
      {EffectId::kLidarScanCone, "lidar scan cone",
       "the beam leaves the scan plane: correct the laser vectors in the pair files (lidar.p2p), "
       "or estimate it",
       LidarScanCone},
      {EffectId::kBoresightDrift, "boresight drift", kMount, BoresightDrift},
      {EffectId::kBoresightStep, "boresight step", kMount, BoresightStep},
  };
  return effects;
}

const EstimableEffect* FindEstimable(EffectId id) {
  const std::vector<EstimableEffect>& all = EstimableEffects();
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const auto& effect) { return id == effect.id; });
  return at == all.end() ? nullptr : &*at;
}

const EstimableEffect* FindEstimable(std::string_view name) {
  const EffectSpec* row = FindEffect(name);
  return row == nullptr ? nullptr : FindEstimable(row->id);
}

}  // namespace dn
