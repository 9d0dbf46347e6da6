#pragma once

#include <dn/files/flight_config.h>
#include <dn/matching/match.h>

#include <filesystem>
#include <memory>
#include <string>

#include "command.h"
#include "flight_run.h"

namespace dn::apps {

/// Strips of a flight with their matches.
struct MatchedFlight {
  FlightConfig config;  ///< names the trajectory in use
  std::unique_ptr<FlightMatchSource> source;
  VectorOrigin origin;  ///< of the laser vectors, the least reliable of all strips
  MatchResult result;
  std::unique_ptr<FlightRun> smoothed;  ///< set if the flight has no trajectory
};

/// Point filter of the planes: last returns only, all classes.
inline const PointFilter kLastReturns{.last_returns = true, .classes = {}};

/// Opens the strips of a flight without matching them. The trajectory is the flight's own, else
/// `trajectory`, else one smoothed from the inertial and GNSS data.
MatchedFlight OpenFlightStrips(FlightConfig config, const std::string& trajectory,
                               const PointFilter& filter, Run& run);

/// Matches the strips of a flight. The trajectory is chosen as in the function above.
MatchedFlight MatchFlightStrips(FlightConfig config, const std::string& trajectory,
                                MatchOptions options, const PointFilter& filter, Run& run);

/// Returns matching options with the threads and the progress callback of the run.
MatchOptions MakeRunMatchOptions(Run& run);

/// Returns the configuration with the pair files lidar/<a>_<b>.txt in `folder`. If the trajectory
/// was smoothed, it refers to the file `trajectory` in the same folder. The prior of
/// lidar_range_offset under `unmodelled` contains the error that all pairs over plants share.
FlightConfig WithMatches(const MatchedFlight& matched, const std::filesystem::path& folder,
                         const std::string& trajectory);

/// Stages match.json and matches/, and prints the counts.
void AddMatchFiles(const std::string& name, const MatchResult& result, const MatchSource& source,
                   Run& run);

/// Stages the files of AddMatchFiles and the pair files of a flight.
void AddMatches(const MatchedFlight& matched, Run& run);

/// Stages <folder>trajectory.out and its trajectory_sigma.txt.
void AddSmoothedTrajectory(const FlightRun& smoothed, const std::string& folder, Run& run);

/// Throws FailedWithResults because no pair was found.
[[noreturn]] void FailNoPairs();

}  // namespace dn::apps
