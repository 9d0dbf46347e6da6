#pragma once

#include <dn/sim/scenario.h>

#include <string>

namespace dn::testing {

/// Returns a flight of a few minutes at a low inertial rate: two strips of opposite heading and a
/// cross strip. The ground is undulating and has houses; the flight has turbulence and crab.
inline Scenario SmallScenario(const std::string& extra = "") {
  return ParseScenario(R"(
name: small
origin_deg_m: [46.57, 6.52, 400]
start_s: 381000
plan:
  warm_up_s: 120
  lines:
    - [-500, 0, 500, 0, 200, 45]
    - [500, 100, -500, 100, 210, 42]
    - [0, -500, 0, 500, 250, 45]
  bank_deg: 25
  turbulence: {roll_deg: 1.0, pitch_deg: 0.7, heading_deg: 0.7, speed_m_s: 1.0, height_m: 2.0}
  crab_deg: 3
terrain: {kind: built_up, relief_m: 30, wavelength_m: 500, buildings_per_km2: 800, seed: 3}
imu: {rate_hz: 20, preset: ln200}
gnss: {rate_hz: 2, sigma_enu_m: [0.02, 0.03, 0.05], lever_arm_m: [0.4, -0.1, -1.1]}
lidar: {R_sensor_to_body: [[0,1,0],[0,0,1],[1,0,0]], scan_axis: [0,1,0], nadir_axis: [1,0,0],
        lever_arm_m: [0.14, -0.02, 0.21], boresight_deg: [0.8, -0.5, 1.2], fov_deg: 75, gsd_m: 0.2}
pairs: {count: 300, sigma_p_m: 0.05}
)" + extra,
                       "small.yaml");
}

}  // namespace dn::testing
