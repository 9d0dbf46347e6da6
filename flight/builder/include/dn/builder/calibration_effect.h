#pragma once

#include <dn/factors/gnss_antenna.h>
#include <dn/factors/lidar_effect.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/flight/effect_times.h>
#include <dn/flight/flight.h>
#include <dn/imu/imu_effect.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace dn {

/// The attraction (m/s^2, map axes) per unit of an effect's values at a point of the map.
using AttractionField = std::function<AttractionBasis(const Eigen::Vector3d& p_m)>;

/// How the values of an effect (SI) change what a sensor reports.
using EffectAction =
    std::variant<std::shared_ptr<const ImuEffect>, std::shared_ptr<const LidarEffect>,
                 std::shared_ptr<const GnssEffect>, AttractionField>;

/// The flight that an effect is in, and when it is there.
struct EffectSite {
  const Flight& flight;
  EffectTimes times{};
};

/// An effect that the estimator knows. Names, units, components and usual sizes are those of the
/// effect table (FindEffect).
struct EstimableEffect {
  const char* name;
  const char* quantity;  ///< in the words of reports: "gyro scale factor"
  const char* remedy;    ///< what to correct where the data show it
  /// Null for an effect that is a block of every network: lever arms, lidar time offset. Throws
  /// InvalidConfig where the site lacks its time, or the flight the section of its sensor.
  EffectAction (*make)(const EffectSite& site);
};

/// Every fixed effect, in the order in which the corrections are applied: the last of the sensor
/// first.
const std::vector<EstimableEffect>& EstimableEffects();

/// The effect of this name; null where the estimator has none.
const EstimableEffect* FindEstimable(std::string_view name);

}  // namespace dn
