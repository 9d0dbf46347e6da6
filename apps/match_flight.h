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

/// The strips of a flight on its trajectory, else on `trajectory`, else on the smoothed one of its
/// inertial and GNSS data; not matched yet.
MatchedFlight OpenStripsOfFlight(FlightConfig config, const std::string& trajectory, Run& run);

/// Matches the strips of a flight on its trajectory, else on `trajectory`, else on the smoothed one
/// of its inertial and GNSS data.
MatchedFlight MatchStripsOfFlight(FlightConfig config, const std::string& trajectory,
                                  MatchOptions options, Run& run);

/// Stages lidar/<a>_<b>.txt, config.resolved.yaml, and the trajectory where it was smoothed.
void AddPairFiles(const MatchedFlight& matched, Run& run);

/// A flight file with the pairs, and the trajectory, that lie in `folder`.
std::string MatchedFlightFile(const MatchedFlight& matched, const std::filesystem::path& folder);

}  // namespace dn::apps
