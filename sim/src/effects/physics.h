#pragma once

#include "effects/registry.h"

/// Physics of the effects, one file per effect or per group with a common formula;
/// docs/reference/formats.md describes each. To add an effect, add a row to EffectTable, a file
/// here, and its name below and in SimulatedEffects.
namespace dn::effects {

void GyroMisalignment(const EffectInput& input, ActiveEffects* active);
void AccelMisalignment(const EffectInput& input, ActiveEffects* active);
void GyroScaleFactor(const EffectInput& input, ActiveEffects* active);
void AccelScaleFactor(const EffectInput& input, ActiveEffects* active);
void GyroGSensitivity(const EffectInput& input, ActiveEffects* active);
void GravityTilt(const EffectInput& input, ActiveEffects* active);
void GravityDisturbance(const EffectInput& input, ActiveEffects* active);
void GyroBiasProcess(const EffectInput& input, ActiveEffects* active);
void AccelBiasProcess(const EffectInput& input, ActiveEffects* active);
void GyroNoiseScale(const EffectInput& input, ActiveEffects* active);
void AccelNoiseScale(const EffectInput& input, ActiveEffects* active);
void ImuVibration(const EffectInput& input, ActiveEffects* active);
void ImuGap(const EffectInput& input, ActiveEffects* active);
void ImuClockStep(const EffectInput& input, ActiveEffects* active);
void GnssLeverArm(const EffectInput& input, ActiveEffects* active);
void GnssNoiseScale(const EffectInput& input, ActiveEffects* active);
void GnssPositionStep(const EffectInput& input, ActiveEffects* active);
void GnssCorrelatedNoise(const EffectInput& input, ActiveEffects* active);
void GnssMultipath(const EffectInput& input, ActiveEffects* active);
void GnssOutliers(const EffectInput& input, ActiveEffects* active);
void GnssOutage(const EffectInput& input, ActiveEffects* active);
void GnssTimeOffset(const EffectInput& input, ActiveEffects* active);
void GnssTimeDrift(const EffectInput& input, ActiveEffects* active);
void GnssClockStep(const EffectInput& input, ActiveEffects* active);
void LidarLeverArm(const EffectInput& input, ActiveEffects* active);
void BoresightDrift(const EffectInput& input, ActiveEffects* active);
void BoresightStep(const EffectInput& input, ActiveEffects* active);
void LidarScanCone(const EffectInput& input, ActiveEffects* active);
void LidarScanTorsion(const EffectInput& input, ActiveEffects* active);
void LidarAngleScale(const EffectInput& input, ActiveEffects* active);
void LidarRangeScale(const EffectInput& input, ActiveEffects* active);
void LidarRangeOffset(const EffectInput& input, ActiveEffects* active);
void LidarTimeOffset(const EffectInput& input, ActiveEffects* active);
void LidarTimeDrift(const EffectInput& input, ActiveEffects* active);
void P2pRangeNoise(const EffectInput& input, ActiveEffects* active);
void P2pNoiseScale(const EffectInput& input, ActiveEffects* active);
void P2pOutliers(const EffectInput& input, ActiveEffects* active);
void TrajectoryAttitudeOffset(const EffectInput& input, ActiveEffects* active);

}  // namespace dn::effects
