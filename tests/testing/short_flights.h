#pragma once

#include <dn/diagnosis/solution.h>
#include <dn/sim/simulate.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace dn::testing {

/// Returns a flight of a small drone 100 m above houses, four minutes in total. It has two opposite
/// strips of 10 s at 20 m/s and a higher cross strip. `extra` adds sections (effects).
inline Scenario DroneScenario(const std::string& extra = "") {
  return ParseScenario(R"(
name: drone
origin_deg_m: [46.57, 6.52, 400]
start_s: 381000
plan:
  warm_up_s: 60
  lines:
    - [-100, 0, 100, 0, 100, 20]
    - [100, 30, -100, 30, 100, 20]
    - [0, -100, 0, 100, 120, 20]
  bank_deg: 25
  turbulence: {roll_deg: 1.0, pitch_deg: 0.7, heading_deg: 0.7, speed_m_s: 0.5, height_m: 0.5}
  crab_deg: 3
terrain: {kind: built_up, relief_m: 10, wavelength_m: 100, buildings_per_km2: 800, seed: 3}
imu: {rate_hz: 100, preset: apx15}
gnss: {rate_hz: 2, sigma_enu_m: [0.015, 0.015, 0.03], lever_arm_m: [0.2, -0.1, -0.4]}
lidar: {R_sensor_to_body: [[0,1,0],[0,0,1],[1,0,0]], scan_axis: [0,1,0], nadir_axis: [1,0,0],
        lever_arm_m: [0.14, -0.02, 0.21], boresight_deg: [0.8, -0.5, 1.2], fov_deg: 75, gsd_m: 0.1}
pairs: {count: 300, sigma_p_m: 0.03}
)" + extra,
                       "drone.yaml");
}

/// Returns a flight of a survey aircraft with a navigation-grade sensor: two opposite strips and a
/// cross strip, with a short warm-up.
inline Scenario AircraftScenario(const std::string& extra = "") {
  return ParseScenario(R"(
name: aircraft
origin_deg_m: [46.57, 6.52, 400]
start_s: 381000
plan:
  warm_up_s: 120
  lines:
    - [-500, 0, 500, 0, 250, 45]
    - [500, 100, -500, 100, 250, 45]
    - [0, -500, 0, 500, 290, 45]
  bank_deg: 25
  turbulence: {roll_deg: 1.0, pitch_deg: 0.7, heading_deg: 0.7, speed_m_s: 1.0, height_m: 2.0}
  crab_deg: 3
terrain: {kind: built_up, relief_m: 30, wavelength_m: 300, buildings_per_km2: 500, seed: 3}
imu: {rate_hz: 100, preset: airins}
gnss: {rate_hz: 1, sigma_enu_m: [0.015, 0.015, 0.03], lever_arm_m: [0.4, -0.1, -1.1]}
lidar: {R_sensor_to_body: [[0,1,0],[0,0,1],[1,0,0]], scan_axis: [0,1,0], nadir_axis: [1,0,0],
        lever_arm_m: [0.14, -0.02, 0.21], boresight_deg: [0.2, 0.03, 0.35], fov_deg: 75, gsd_m: 0.2}
pairs: {count: 400}
)" + extra,
                       "aircraft.yaml");
}

/// A solved flight with its boresight; the original flight must outlive it.
struct Calibration {
  Solution solution;
  const Adjustment& adjustment;
  const Marginals& marginals;
  BoresightResult boresight;

  explicit Calibration(const Flight& flight, const AdjustOptions& options = {})
      : solution(flight, options),
        adjustment(solution.adjustment()),
        marginals(solution.marginals()),
        boresight(solution.Boresight()) {}
  Calibration(const Calibration&) = delete;
  Calibration& operator=(const Calibration&) = delete;

  /// Returns the error of the boresight in the coordinates of its covariance: the left perturbation
  /// from the truth.
  Eigen::Vector3d BoresightError(const Eigen::Vector3d& true_rad) const {
    return Log(Eigen::Quaterniond(Exp(boresight.angles_rad) * Exp(true_rad).conjugate()));
  }
};

/// Returns a simulated flight of a scenario.
inline SimulatedFlight Fly(const Scenario& scenario, std::uint64_t seed, bool noise = true) {
  SimulateOptions options;
  options.seed = seed;
  options.noise = noise;
  return Simulate(scenario, options);
}

}  // namespace dn::testing
