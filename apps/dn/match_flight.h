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

/// The trajectory of a flight with its origin.
struct FlightPath {
  StripSourceOptions options;  ///< with the trajectory only
  LocalFrame frame{Geodetic{}};
  std::unique_ptr<FlightRun> smoothed;  ///< set if the flight has no trajectory
};

/// Throws InvalidConfig for a flight without scanner, and for strips without a trajectory.
void ExpectMatchable(const FlightConfig& config);

/// Returns the flight's own trajectory, else `trajectory`, else one smoothed from the inertial and
/// GNSS data. `config` then names the trajectory in use.
FlightPath FindFlightPath(FlightConfig* config, const std::string& trajectory, Run& run);

/// Opens the strips of a flight with one scanner without matching them.
MatchedFlight OpenStrips(FlightConfig config, const FlightPath& path, const PointFilter& filter,
                         Run& run);

/// Does both. Throws InvalidConfig for several scanners.
MatchedFlight OpenFlightStrips(FlightConfig config, const std::string& trajectory,
                               const PointFilter& filter, Run& run);

/// Matches opened strips. Values that the options lack are those of the flight.
void MatchOpened(MatchOptions options, MatchedFlight* matched);

/// Opens and matches the strips of a flight with one scanner.
MatchedFlight MatchFlightStrips(FlightConfig config, const std::string& trajectory,
                                const MatchOptions& options, const PointFilter& filter, Run& run);

/// Returns the error of pairs that the sigma of the range offset of plants leaves, as a sigma of
/// lidar_range_offset: all pairs share it.
double SharedRangeSigma(const MatchResult& result);

/// Adds a shared error of this size to the prior of lidar_range_offset, unless the flight has the
/// pure model.
void AddRangeOffset(double sigma_m, FlightConfig* config);

/// Returns matching options with the threads and the progress callback of the run.
MatchOptions MakeRunMatchOptions(Run& run);

/// Returns the configuration with the pair files lidar/<a>_<b>.txt and the files of surface pairs
/// surfaces/<a>_<b>.txt in `folder`. If the trajectory was smoothed, it refers to the file
/// `trajectory` in the same folder. The prior of lidar_range_offset under `unmodelled` contains the
/// error that all pairs over plants share.
FlightConfig WithMatches(const MatchedFlight& matched, const std::filesystem::path& folder,
                         const std::string& trajectory);

/// Stages match.json and matches/, and prints the counts. match.json also has the keys of `more`.
void AddMatchFiles(const std::string& name, const MatchResult& result, const MatchSource& source,
                   Run& run, const Json& more = Json::object());

/// Time offsets of the scanners of the two ends of a pair (LidarConfig::time_offset_s).
struct EndOffsets {
  double i_s = 0.0, j_s = 0.0;
};

/// Stages the file of the pairs of two strips, with the time tags of the scanners. Without any pair
/// there is no file.
void AddPairFile(const std::string& name, const StripPairMatch& match, const MatchResult& result,
                 const EndOffsets& offsets, Run& run);

/// Stages the files of AddMatchFiles and the pair files of a flight.
void AddMatches(const MatchedFlight& matched, Run& run);

/// Stages <folder>trajectory.out and its trajectory_sigma.txt.
void AddSmoothedTrajectory(const FlightRun& smoothed, const std::string& folder, Run& run);

/// Throws FailedWithResults because no pair was found.
[[noreturn]] void FailNoPairs();

}  // namespace dn::apps
