#pragma once

#include <dn/flight/flight_config.h>
#include <dn/flight/map_gnss.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>
#include <dn/lidar/pairs.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// What a command wants to read of a flight folder.
struct FlightNeeds {
  bool imu = false;
  bool gnss = false;
  bool pairs = false;
  bool trajectory = false;
  /// Of the above, read what is there and leave out what is not (dn check).
  bool optional = false;
  /// Beside the inertial data the reference is read, where there is another thread.
  int threads = 1;
};

/// A flight folder in memory: SI, radian, body forward-right-down, times continued over a week
/// rollover.
struct Flight {
  FlightConfig config;
  LocalFrame frame{Geodetic{}};
  std::optional<ImuData> imu;
  std::optional<MapGnss> gnss;    ///< only epochs inside time_span_s
  std::optional<PairData> pairs;  ///< after pairs: {strategy, ...}; outside time_span_s dropped
  /// Strips, found from all pairs before the selection (FindStrips).
  std::vector<StripInterval> pair_strips;
  std::optional<Trajectory> trajectory;
  std::optional<Trajectory> initial_guess;  ///< read where present
  std::optional<Trajectory> reference;      ///< read where present
  /// Counts kept and dropped by reason ("gnss rows outside time span": 3), for report.json.
  std::map<std::string, long> counts;
  double read_time_s = 0.0;
};

/// Reads a flight folder. The frame's origin: config, else first position of the GNSS file (also
/// when GNSS is not asked for), else first trajectory position. Files that flight.yaml leaves at
/// their default names may also be trajectory.txt and lidar/*.txt; a trajectory under its default
/// name needs no section.
///
/// GNSS epochs outside time_span_s or the IMU data, pairs outside time_span_s, repeated pairs, and
/// GNSS epochs and pairs in gaps of the IMU data or the trajectory are dropped and counted. Throws
/// InvalidConfig when the folder, flight.yaml or a needed section is missing, InvalidInput for a
/// missing file (naming its path and key), bad data, no overlap of IMU and GNSS (naming both
/// spans), pair epochs outside the IMU data or trajectory that was read (naming the epoch, file and
/// line), and more than half of the pairs in gaps. With `optional`, pairs must lie inside one of
/// the two; those outside the other and those in gaps are counted and kept.
Flight ReadFlight(const std::filesystem::path& folder, const FlightNeeds& needs);

/// The same with a configuration at hand, say with another trajectory file; relative file names
/// start at config.folder.
Flight ReadFlight(const FlightConfig& config, const FlightNeeds& needs);

/// The pairs that a selection keeps, in their order; the same for the same seed.
///   max: `count` pairs, equal shares of the files (strip pairs), one at random out of each of as
///        many equal parts of a file in order of t_i;
///   freq: per file, the pair nearest to each tick of a raster of freq_hz that starts at its first
///        t_i, where one lies within half a period;
///   time_window: per file, one at random out of each window_s that holds any.
/// Throws InvalidConfig when the strategy's parameter is missing or not positive.
std::vector<LidarPair> SelectPairs(const std::vector<LidarPair>& pairs,
                                   const PairSelection& selection);

/// Time intervals of strips: those of the config; else clusters of the pairs' epochs (a hole of
/// more than 5 s separates two strips), of all pairs where ReadFlight read them; else straight legs
/// of the trajectory of at least 10 s.
std::vector<StripInterval> FindStrips(const Flight& flight);

/// The straight legs of a trajectory of at least 10 s.
std::vector<StripInterval> FindStrips(const Trajectory& trajectory);

}  // namespace dn
