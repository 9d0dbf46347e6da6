#pragma once

#include <dn/flight/flight_config.h>
#include <dn/matching/match.h>

#include <filesystem>
#include <memory>
#include <string>

#include "command.h"
#include "flight_run.h"

namespace dn::apps {

/// The strips of a flight, matched.
struct MatchedFlight {
  FlightConfig config;  ///< with the trajectory in use
  std::unique_ptr<FlightMatchSource> source;
  MatchResult result;
  std::unique_ptr<FlightRun> smoothed;  ///< where the flight has no trajectory
};

/// What of the strips is used where nothing else is asked for: the last returns.
inline const PointFilter kLastReturns{.last_returns = true, .classes = {}};

/// The strips of a flight on its trajectory, else on `trajectory`, else on the smoothed one of its
/// inertial and GNSS data; not matched yet.
MatchedFlight OpenStripsOfFlight(FlightConfig config, const std::string& trajectory,
                                 const PointFilter& filter, Run& run);

/// Matches the strips of a flight on its trajectory, else on `trajectory`, else on the smoothed one
/// of its inertial and GNSS data.
MatchedFlight MatchStripsOfFlight(FlightConfig config, const std::string& trajectory,
                                  MatchOptions options, const PointFilter& filter, Run& run);

/// Options of a run: its threads, its progress.
MatchOptions MatchOptionsOf(Run& run);

/// The flight with its pairs, lidar/<a>_<b>.txt in a folder, and the trajectory in it that was
/// smoothed, where one was.
FlightConfig WithMatches(const MatchedFlight& matched, const std::filesystem::path& folder,
                         const std::string& trajectory);

/// Stages match.json and matches/, and prints the counts.
void AddMatchFiles(const std::string& name, const MatchResult& result, const MatchSource& source,
                   Run& run);

/// The same with the pair files of a flight.
void AddMatches(const MatchedFlight& matched, Run& run);

/// Stages <folder>trajectory.out and its trajectory_sigma.txt.
void AddSmoothedTrajectory(const FlightRun& smoothed, const std::string& folder, Run& run);

/// Ends a run that found no pair, with its results.
[[noreturn]] void FailNoPairs();

}  // namespace dn::apps
