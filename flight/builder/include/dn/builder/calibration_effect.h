#pragma once

#include <dn/effects/effect_table.h>
#include <dn/factors/gnss_antenna.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/files/effect_times.h>
#include <dn/files/flight.h>
#include <dn/imu/imu_effect.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace dn {

/// Returns the gravitation per unit of each value of an effect at a point of the map, map axes,
/// m/s^2 per unit.
using GravitationField = std::function<GravitationBasis(const Eigen::Vector3d& p_m)>;

/// The way in which the values of an effect (SI) change the readings of a sensor.
using EffectAction =
    std::variant<std::shared_ptr<const ImuEffect>, std::shared_ptr<const LidarEffect>,
                 std::shared_ptr<const GnssEffect>, GravitationField>;

/// The flight in which an effect acts, the times at which it acts, and the scanner that has it.
struct EffectSite {
  const Flight& flight;
  EffectTimes times{};
  std::size_t scanner = 0;
};

/// An effect that the estimator can estimate. Its names, units, components and typical sizes are in
/// the effect table (FindEffect).
struct EstimableEffect {
  EffectId id;
  const char* quantity;  ///< name in reports: "gyro scale factor"
  const char* remedy;    ///< advice for the user if the data indicate this effect
  /// Throws InvalidConfig if the site lacks the time of the effect, or the flight lacks the section
  /// of its sensor.
  EffectAction (*make)(const EffectSite& site);
  /// Configured value, SI, of an effect that is a block of every network, estimated or constant.
  /// Null for an effect that is a block only where it is estimated; its configured value is zero.
  Eigen::VectorXd (*configured)(const FlightConfig& config, std::size_t scanner) = nullptr;

  const std::string& name() const { return EffectName(id); }
};

/// Makes the action of an effect. In a flight with several scanners, an effect of the lidar acts on
/// the readings of its scanner alone. Throws like EstimableEffect::make.
EffectAction MakeAction(const EstimableEffect& effect, const EffectSite& site);

/// Returns the action of an effect of the lidar on the readings of one scanner alone; every other
/// action unchanged.
EffectAction OnScanner(EffectAction action, std::size_t scanner);

/// Returns every fixed effect in the order in which the corrections are applied: the effect that
/// acts last in the sensor is corrected first.
const std::vector<EstimableEffect>& EstimableEffects();

/// Returns the effect with this id or name; null if the estimator has no such effect.
const EstimableEffect* FindEstimable(EffectId id);
const EstimableEffect* FindEstimable(std::string_view name);

}  // namespace dn
