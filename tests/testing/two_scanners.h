#pragma once

#include <dn/sim/scenario.h>

#include <cmath>
#include <string>

#include "testing/short_flights.h"

namespace dn::testing {

/// Returns DroneScenario with a second scanner `b` whose scan plane leans 30 deg forward.
inline Scenario TwoScannerScenario(long pairs, long between, const std::string& extra = "") {
  Scenario scenario = DroneScenario(extra);
  scenario.lidar.name = "a";
  LidarScenario b = scenario.lidar;
  b.name = "b";
  b.mounting.R_bs_nominal << 0.5, std::sqrt(0.75), 0.0, 0.0, 0.0, 1.0, std::sqrt(0.75), -0.5, 0.0;
  b.mounting.lever_arm_b_m = {0.32, 0.11, 0.18};
  b.mounting.boresight_rad = kRadPerDeg * Eigen::Vector3d(-0.4, 0.9, -0.7);
  scenario.more_scanners = {b};
  scenario.pairs.count = pairs;
  scenario.pairs.between = between;
  return scenario;
}

}  // namespace dn::testing
