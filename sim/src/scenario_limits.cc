#include "scenario_limits.h"

#include <dn/error.h>
#include <dn/geo/text_table.h>

#include <cmath>
#include <string>

namespace dn {
namespace {

// Farther away, the horizontal plane of the map deviates too much from the ground.
constexpr double kFarthest_m = 1e6;
constexpr double kHighest_m = 1e5;
constexpr double kLargestRelief_m = 1e4;
constexpr double kLongestFlight_s = 86400.0;
constexpr double kLongestWarmUp_s = 4.0 * 3600.0;
constexpr double kRoughest_m = 10.0;
constexpr double kMostPulses_hz = 1e7;
// The points of so many pulses take some 200 GB.
constexpr double kMostPulses = 5e9;
constexpr long kMostPairs = 5000000;
// A sample, its true state and their text need about half a kB.
constexpr double kMostSamples = 1e7;

void ExpectAtMost(
    const char* what, double value, double most, const char* unit,
    const std::function<FileLocation()>& place = [] { return FileLocation(); }) {
  if (std::abs(value) <= most) return;
  throw InvalidConfig(std::string("scenario: ") + what + " is " + FormatDouble(value) + unit +
                          ", but at most " + FormatDouble(most) + unit + " can be simulated",
                      place());
}

}  // namespace

void CheckLimits(const Scenario& scenario, const KeyLocator& place) {
  const PlanScenario& plan = scenario.plan;
  const auto at = [&place](const char* section, const char* key) {
    return [&place, section, key] { return place(section, key); };
  };
  const auto lines = at("plan", "lines");
  ExpectAtMost("plan.warm_up_s", plan.warm_up_s, kLongestWarmUp_s, " s", at("plan", "warm_up_s"));
  for (const PlannedLine& line : plan.lines) {
    for (const Eigen::Vector2d& end : {line.start_en_m, line.end_en_m}) {
      ExpectAtMost("an end of plan.lines", end.cwiseAbs().maxCoeff(), kFarthest_m,
                   " m from the origin", lines);
    }
    ExpectAtMost("a height of plan.lines", line.height_m, kHighest_m, " m", lines);
  }
  ExpectAtMost("terrain.relief_m", scenario.terrain.relief_m, kLargestRelief_m, " m",
               at("terrain", "relief_m"));
  ExpectAtMost("terrain.base_m", scenario.terrain.base_m, kHighest_m, " m",
               at("terrain", "base_m"));
  ExpectAtMost("terrain.roughness_m", scenario.terrain.roughness_m, kRoughest_m, " m",
               at("terrain", "roughness_m"));
  ExpectAtMost("lidar.pulse_rate_hz", scenario.lidar.pulse_rate_hz, kMostPulses_hz, " Hz",
               at("lidar", "pulse_rate_hz"));
  ExpectAtMost("pairs.count", static_cast<double>(scenario.pairs.count),
               static_cast<double>(kMostPairs), "", at("pairs", "count"));
}

void CheckDuration(double duration_s) {
  ExpectAtMost("the time to fly plan.lines and plan.warm_up_s", duration_s, kLongestFlight_s, " s");
}

void CheckPulses(const LidarScenario& lidar, double strips_s) {
  ExpectAtMost("the number of pulses, the strips' duration times lidar.pulse_rate_hz,",
               std::floor(strips_s * lidar.pulse_rate_hz), kMostPulses, "");
}

void CheckSamples(const ImuScenario& imu, double duration_s) {
  ExpectAtMost("the number of inertial samples, the flight's duration times imu.rate_hz,",
               std::floor(duration_s * imu.rate_hz), kMostSamples, "");
}

}  // namespace dn
