#pragma once

#include <dn/calibration/result_files.h>
#include <dn/calibration/solution.h>
#include <dn/flight/flight.h>

#include <optional>

#include "command.h"

namespace dn::apps {

/// A flight adjusted for `dn smooth` or `dn calibrate`.
struct FlightRun {
  Flight flight;
  std::vector<std::string> hints;    ///< what its data show before the adjustment
  std::optional<Solution> solution;  ///< of `flight`
  Trajectory trajectory;             ///< of the solution, at 100 Hz
  RunTimings timings;

  const Adjustment& adjustment() const { return solution->adjustment(); }
};

/// Reads, adjusts and factors a flight, with progress and the parts of report.json that are common.
std::unique_ptr<FlightRun> AdjustFlight(const FlightConfig& config, bool with_pairs, Run* run);

/// The same for a flight that was read already, with imu and gnss (and pairs), in read_s seconds.
std::unique_ptr<FlightRun> AdjustFlight(Flight flight, double read_s, bool with_pairs, Run* run);

/// Stages trajectory.out, trajectory_sigma.txt, biases.txt, config.resolved.yaml and the plots.
void AddTrajectoryFiles(const FlightRun& flight_run, Run* run);

/// Fills report.json's counts, statistics, stages and timings.
void FillReport(const FlightRun& flight_run, Run* run);

/// Prints offset and drift of the clocks with their sigmas.
void PrintClocks(const Clocks& clocks);

/// Prints the first reasons of an assessment, a line each, and where the others are.
void PrintReasons(const std::vector<std::string>& reasons, const std::string& file);

/// Ends the work with its results and the error that the data contradict the assumed model, by its
/// first finding; `file` has all of them.
[[noreturn]] void ThrowContradicted(const std::string& first_finding, const std::string& file);

}  // namespace dn::apps
