#pragma once

#include <dn/adjustment/unknown_noise.h>
#include <dn/diagnosis/result_files.h>
#include <dn/diagnosis/solution.h>
#include <dn/files/flight.h>

#include <optional>

#include "command.h"

namespace dn::apps {

/// A flight adjusted for `dn smooth` or `dn calibrate`.
struct FlightRun {
  Flight flight;
  std::vector<std::string> hints;    ///< likely mistakes, found before the adjustment
  std::optional<NoiseSizes> noise;   ///< estimated first if imu.grade is unknown
  std::optional<Solution> solution;  ///< adjustment of `flight`
  Trajectory trajectory;  ///< adjusted trajectory at 100 Hz, by Solution::CheckedTrajectory
  std::vector<NavPoint> modelled;  ///< the same by the pure model, as the network has it
  RunTimings timings;

  const Adjustment& adjustment() const { return solution->adjustment(); }
};

/// Reads and adjusts a flight and factorises its network. Reports progress and fills the parts of
/// report.json that `dn smooth` and `dn calibrate` share.
std::unique_ptr<FlightRun> AdjustFlight(const FlightConfig& config, bool with_pairs, Run* run);

/// Adjusts a flight that is already read, with imu and gnss (and pairs). read_s: reading time, s.
std::unique_ptr<FlightRun> AdjustFlight(Flight flight, double read_s, bool with_pairs, Run* run);

/// Stages trajectory.out, trajectory_sigma.txt, biases.txt, config.resolved.yaml and the plots.
void AddTrajectoryFiles(const FlightRun& flight_run, Run* run);

/// Fills report.json's counts, statistics, stages and timings.
void FillReport(const FlightRun& flight_run, Run* run);

/// Prints offset and drift of the clocks with their sigmas.
void PrintClocks(const Clocks& clocks);

/// Prints the first reasons of an assessment, one per line, and names the file with the others.
void PrintReasons(const std::vector<std::string>& reasons, const std::string& file);

/// Throws FailedWithResults: the data contradict the assumed model. The message quotes the first
/// finding and refers to `file` for all findings.
[[noreturn]] void ThrowContradicted(const std::string& first_finding, const std::string& file);

}  // namespace dn::apps
