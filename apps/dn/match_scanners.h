#pragma once

#include <dn/files/flight_config.h>
#include <dn/files/scanners.h>
#include <dn/matching/match.h>

#include <filesystem>
#include <memory>
#include <string>

#include "command.h"
#include "match_jointly.h"

namespace dn::apps {

/// Strips of a flight with several scanners: the matches of each scanner, and those of every two
/// scanners with each other.
struct MatchedScanners : JointMatches {
  FlightConfig config;                  ///< names the trajectory in use
  std::unique_ptr<FlightRun> smoothed;  ///< set if the flight has no trajectory
};

/// Matches the strips. The trajectory is that of FindFlightPath.
MatchedScanners MatchScannerStrips(FlightConfig config, const std::string& trajectory,
                                   const MatchOptions& options, const PointFilter& filter,
                                   Run& run);

/// Stages the pair files lidar_<a>/ and lidar_<a>_<b>/ and the files of AddMatchFiles.
void AddMatches(const MatchedScanners& matched, Run& run);

/// Returns the configuration with the pair files in `folder`, as WithMatches of one scanner does.
FlightConfig WithMatches(const MatchedScanners& matched, const std::filesystem::path& folder,
                         const std::string& trajectory);

}  // namespace dn::apps
