#pragma once

#include <dn/config/yaml_value.h>
#include <dn/sim/scenario.h>

#include <string>

namespace dn::testing {

/// Two opposite strips of a minute each over rolling ground, with the inertial sensor apx15.
inline const std::string kTwoStrips = R"(
name: two
origin_deg_m: [46.57, 6.52, 400]
start_s: 381000
plan:
  warm_up_s: 120
  lines:
    - [-600, 0, 600, 0, 200, 45]
    - [600, 60, -600, 60, 200, 45]
  bank_deg: 25
  turbulence: {roll_deg: 1.0, pitch_deg: 0.7, heading_deg: 0.7, speed_m_s: 1.0, height_m: 2.0}
  crab_deg: 3
terrain: {kind: built_up, relief_m: 30, wavelength_m: 500, buildings_per_km2: 800, seed: 3}
imu: {rate_hz: 100, preset: apx15}
gnss: {rate_hz: 1, sigma_enu_m: [0.02, 0.02, 0.04], lever_arm_m: [0.4, -0.1, -1.1]}
lidar: {R_sensor_to_body: [[0,1,0],[0,0,1],[1,0,0]], scan_axis: [0,1,0], nadir_axis: [1,0,0],
        lever_arm_m: [0.14, -0.02, 0.21], boresight_deg: [0.2, -0.1, 0.3], fov_deg: 75, gsd_m: 0.2}
pairs: {count: 600}
)";

/// Returns the two strips with one value changed.
inline Scenario TwoStripsWith(const std::string& path, const std::string& value) {
  return ParseScenario(WithYamlValue(kTwoStrips, path, value), "two.yaml");
}

inline Scenario TwoStrips() { return ParseScenario(kTwoStrips, "two.yaml"); }

inline const char* const kWithCrossStrip =
    "[[-600, 0, 600, 0, 200, 45], [600, 60, -600, 60, 200, 45], [0, -600, 0, 600, 240, 45]]";

}  // namespace dn::testing
