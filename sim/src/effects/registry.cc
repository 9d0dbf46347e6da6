#include "effects/registry.h"

#include "effects/physics.h"

namespace dn {

const std::vector<SimulatedEffect>& SimulatedEffects() {
  static const std::vector<SimulatedEffect> effects{
      {EffectId::kGyroMisalignment, &effects::GyroMisalignment},
      {EffectId::kAccelMisalignment, &effects::AccelMisalignment},
      {EffectId::kGyroScaleFactor, &effects::GyroScaleFactor},
      {EffectId::kAccelScaleFactor, &effects::AccelScaleFactor},
      {EffectId::kGyroGSensitivity, &effects::GyroGSensitivity},
      {EffectId::kGravityTilt, &effects::GravityTilt},
      {EffectId::kGravityDisturbance, &effects::GravityDisturbance},
      {EffectId::kGyroBiasProcess, &effects::GyroBiasProcess},
      {EffectId::kAccelBiasProcess, &effects::AccelBiasProcess},
      {EffectId::kGyroNoiseScale, &effects::GyroNoiseScale},
      {EffectId::kAccelNoiseScale, &effects::AccelNoiseScale},
      {EffectId::kImuVibration, &effects::ImuVibration},
      {EffectId::kImuGap, &effects::ImuGap},
      {EffectId::kImuClockStep, &effects::ImuClockStep},
      {EffectId::kGnssLeverArm, &effects::GnssLeverArm},
      {EffectId::kGnssNoiseScale, &effects::GnssNoiseScale},
      {EffectId::kGnssPositionStep, &effects::GnssPositionStep},
      {EffectId::kGnssCorrelatedNoise, &effects::GnssCorrelatedNoise},
      {EffectId::kGnssMultipath, &effects::GnssMultipath},
      {EffectId::kGnssOutliers, &effects::GnssOutliers},
      {EffectId::kGnssOutage, &effects::GnssOutage},
      {EffectId::kGnssTimeOffset, &effects::GnssTimeOffset},
      {EffectId::kGnssTimeDrift, &effects::GnssTimeDrift},
      {EffectId::kGnssClockStep, &effects::GnssClockStep},
      {EffectId::kLidarLeverArm, &effects::LidarLeverArm},
      {EffectId::kBoresightDrift, &effects::BoresightDrift},
      {EffectId::kBoresightStep, &effects::BoresightStep},
      {EffectId::kLidarScanCone, &effects::LidarScanCone},
      {EffectId::kLidarScanTorsion, &effects::LidarScanTorsion},
      {EffectId::kLidarAngleScale, &effects::LidarAngleScale},
      {EffectId::kLidarRangeScale, &effects::LidarRangeScale},
      {EffectId::kLidarRangeOffset, &effects::LidarRangeOffset},
      {EffectId::kLidarTimeOffset, &effects::LidarTimeOffset},
      {EffectId::kLidarTimeDrift, &effects::LidarTimeDrift},
      {EffectId::kP2pRangeNoise, &effects::P2pRangeNoise},
      {EffectId::kP2pNoiseScale, &effects::P2pNoiseScale},
      {EffectId::kP2pOutliers, &effects::P2pOutliers},
      {EffectId::kTrajectoryAttitudeOffset, &effects::TrajectoryAttitudeOffset},
  };
  return effects;
}

}  // namespace dn
