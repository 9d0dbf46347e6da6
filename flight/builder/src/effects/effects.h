#pragma once

#include <dn/builder/calibration_effect.h>

#include <utility>

namespace dn::builder_internal {

/// Each function makes the effect of the same name; see EstimableEffect::make.
EffectAction AccelScaleFactor(const EffectSite& site);
EffectAction AccelMisalignment(const EffectSite& site);
EffectAction GyroGSensitivity(const EffectSite& site);
EffectAction GyroScaleFactor(const EffectSite& site);
EffectAction GyroMisalignment(const EffectSite& site);
EffectAction GravityTilt(const EffectSite& site);
EffectAction GravityDisturbance(const EffectSite& site);
EffectAction GnssLeverArm(const EffectSite& site);
EffectAction GnssTimeOffset(const EffectSite& site);
EffectAction GnssTimeDrift(const EffectSite& site);
EffectAction GnssPositionStep(const EffectSite& site);
EffectAction LidarLeverArm(const EffectSite& site);
EffectAction LidarTimeOffset(const EffectSite& site);
EffectAction LidarTimeDrift(const EffectSite& site);
EffectAction LidarRangeOffset(const EffectSite& site);
EffectAction LidarRangeScale(const EffectSite& site);
EffectAction LidarAngleScale(const EffectSite& site);
EffectAction LidarScanCone(const EffectSite& site);
EffectAction LidarScanTorsion(const EffectSite& site);
EffectAction BoresightDrift(const EffectSite& site);
EffectAction BoresightStep(const EffectSite& site);

/// Make the corrections of the beams of a scanner; see BeamAction.
EffectAction BeamAngles(const LidarConfig& lidar, int beams);
EffectAction BeamRanges(int beams);

/// These functions return the configured value of an effect; see EstimableEffect::configured.
Eigen::VectorXd ConfiguredGnssLeverArm(const FlightConfig& config, std::size_t scanner);
Eigen::VectorXd ConfiguredLidarLeverArm(const FlightConfig& config, std::size_t scanner);
Eigen::VectorXd ConfiguredLidarTimeOffset(const FlightConfig& config, std::size_t scanner);

/// Returns the first and last time tag of the pairs, s. Without pairs it is the span of the strips,
/// and without these both are 0.
std::pair<double, double> LidarSpan(const Flight& flight);

}  // namespace dn::builder_internal
