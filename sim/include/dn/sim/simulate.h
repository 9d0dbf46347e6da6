#pragma once

#include <dn/flight/atomic_file.h>
#include <dn/flight/flight.h>
#include <dn/sim/own_errors.h>
#include <dn/sim/scenario.h>
#include <dn/sim/simulated_clouds.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace dn {

/// How a scenario is simulated.
struct SimulateOptions {
  std::uint64_t seed =
      1;  ///< of noise, turbulence and the choice of pairs; the terrain has its own
  /// false: noise and biases of every sensor are zero, stochastic effects are left out; fixed
  /// effects and faults stay, and flight.yaml still holds the assumed model.
  bool noise = true;
  OwnErrors own = {};  ///< beside the scenario's effects; they have no place in truth.yaml
  /// Replayed in place of the file that the scenario's plan names; must outlive the call.
  const Trajectory* replay = nullptr;
  /// Called with the stage ("trajectory", "imu", "gnss", "pairs") and its fraction done.
  std::function<void(const std::string& stage, double fraction)> progress = nullptr;
};

/// A flight and the truth behind it.
struct SimulatedFlight {
  Scenario scenario;
  std::uint64_t seed = 1;
  LocalFrame frame{Geodetic{}};
  std::shared_ptr<const TruthTrajectory> truth;
  /// What ReadFlight gives of the written folder: the assumed model and the measurements.
  Flight flight;
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();        ///< true
  Eigen::Vector3d gnss_lever_arm_b_m = Eigen::Vector3d::Zero();   ///< true
  Eigen::Vector3d lidar_lever_arm_b_m = Eigen::Vector3d::Zero();  ///< true
  /// True bias (sum of all processes, mean over the interval) of every inertial sample.
  std::vector<Eigen::Vector3d> gyro_bias_radps;
  std::vector<Eigen::Vector3d> accel_bias_mps2;
  std::vector<StripInterval> strips;
  /// Of the strips; null where the scenario asks for none.
  std::shared_ptr<const SimulatedClouds> clouds;
};

/// When a flight begins and ends, and its strips, in GPS seconds of week.
struct FlightTimes {
  double begin_s = 0.0;
  double end_s = 0.0;
  std::vector<StripInterval> strips;
};

/// The times that Simulate would have, without flying. Throws as Simulate for the plan.
FlightTimes PlannedTimes(const Scenario& scenario, std::uint64_t seed);

/// Flies the scenario. Throws InvalidConfig when it cannot be flown (no two strips overlap, a line
/// below the ground), InvalidInput for a bad trajectory to replay.
SimulatedFlight Simulate(const Scenario& scenario, const SimulateOptions& options);

/// Adds flight.yaml, IMU.txt, GPS.txt, lidar/<a>_<b>.txt, reference.out (SBET at the inertial
/// rate), truth.yaml and, with the effect trajectory_attitude_offset, trajectory.out to
/// `directory`; the caller commits. Not the point clouds: WriteClouds.
void WriteFlight(const SimulatedFlight& simulated, OutputDirectory& directory);

/// The same without what tells the truth, reference.out and truth.yaml.
void WriteMeasurements(const SimulatedFlight& simulated, OutputDirectory& directory);

/// Adds the point clouds, strips/<name>.las; of a flight without any, nothing. Returns their counts.
/// `progress` is told of each strip the fraction done and may throw to end the work.
std::vector<CloudCounts> WriteClouds(
    const SimulatedFlight& simulated, int threads, OutputDirectory& directory,
    const std::function<void(const StripInterval& strip, double fraction)>& progress);

/// The text of truth.yaml.
std::string FormatTruth(const SimulatedFlight& simulated);

}  // namespace dn
