#pragma once

#include <dn/files/atomic_file.h>
#include <dn/files/flight.h>
#include <dn/imu/imu_rows.h>
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

/// Options of Simulate.
struct SimulateOptions {
  /// Seed of noise, turbulence and the selection of pairs; the terrain has its own seed.
  std::uint64_t seed = 1;
  /// False: noise and biases of every sensor are zero, and stochastic effects are omitted. Fixed
  /// effects and faults remain, and flight.yaml still contains the assumed model.
  bool noise = true;
  /// Errors in addition to the effects of the scenario; truth.yaml does not contain them.
  OwnErrors own = {};
  /// Trajectory to replay instead of the file that the plan names. It must outlive the call.
  const Trajectory* replay = nullptr;
  /// Called with the stage ("trajectory", "imu", "gnss", "pairs") and the fraction done, 0 to 1.
  std::function<void(const std::string& stage, double fraction)> progress = nullptr;
};

/// Simulated flight with its true values.
struct SimulatedFlight {
  Scenario scenario;
  std::uint64_t seed = 1;
  LocalFrame frame{Geodetic{}};
  std::shared_ptr<const TruthTrajectory> truth;
  /// Result of ReadFlight for the written folder: the assumed model and the measurements.
  Flight flight;
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();        ///< true value
  Eigen::Vector3d gnss_lever_arm_b_m = Eigen::Vector3d::Zero();   ///< true value
  Eigen::Vector3d lidar_lever_arm_b_m = Eigen::Vector3d::Zero();  ///< true value
  /// True boresights and lever arms of the scanners after the first.
  std::vector<Eigen::Vector3d> more_boresights_rad;
  std::vector<Eigen::Vector3d> more_lever_arms_b_m;
  /// True bias of every inertial sample: sum of all processes, mean over the interval.
  std::vector<Eigen::Vector3d> gyro_bias_radps;
  std::vector<Eigen::Vector3d> accel_bias_mps2;
  /// Rows of IMU.txt if they are point samples (imu.sampling); else empty, and flight.imu has them.
  std::vector<ImuRow> imu_rows;
  std::vector<StripInterval> strips;
  /// Point clouds of the strips by the first scanner; null if the scenario does not ask for them.
  std::shared_ptr<const SimulatedClouds> clouds;
  std::vector<std::shared_ptr<const SimulatedClouds>> more_clouds;  ///< of the other scanners
};

/// Begin and end of a flight and its strips, in GPS seconds of week.
struct FlightTimes {
  double begin_s = 0.0;
  double end_s = 0.0;
  std::vector<StripInterval> strips;
};

/// Returns the times of the flight that Simulate would create, without simulating it. Throws as
/// Simulate does for the plan.
FlightTimes PlannedTimes(const Scenario& scenario, std::uint64_t seed);

/// Simulates the scenario. Throws InvalidConfig if it cannot be flown (a line below the ground, or
/// no two strips that overlap). Throws InvalidInput for an invalid trajectory to replay.
SimulatedFlight Simulate(const Scenario& scenario, const SimulateOptions& options);

/// Adds the files of the flight to `directory`; the caller commits them. They are
///
///   flight.yaml, IMU.txt, GPS.txt
///   lidar/<a>_<b>.txt; for scanners of a list lidar_<name>/, and lidar_<name>_<name>/ between two
///   control/points.txt, control/checks.txt
///   reference.out (SBET at the inertial rate) and truth.yaml
///
/// The effect trajectory_attitude_offset adds trajectory.out. Point clouds are not included; see
/// WriteClouds.
void WriteFlight(const SimulatedFlight& simulated, OutputDirectory& directory);

/// Adds the files of WriteFlight except reference.out and truth.yaml, which contain the truth.
void WriteMeasurements(const SimulatedFlight& simulated, OutputDirectory& directory);

/// Adds the point clouds, strips/<name>.las, for scanners of a list strips_<scanner>/<name>.las.
/// Returns their counts: all strips of the first scanner, then those of the others. A flight
/// without clouds adds nothing. `progress` receives the fraction done of each strip and may throw
/// to stop the work.
std::vector<CloudCounts> WriteClouds(
    const SimulatedFlight& simulated, int threads, OutputDirectory& directory,
    const std::function<void(const StripInterval& strip, double fraction)>& progress);

/// Formats the text of truth.yaml.
std::string FormatTruth(const SimulatedFlight& simulated);

}  // namespace dn
