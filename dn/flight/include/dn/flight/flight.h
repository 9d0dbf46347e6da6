#pragma once

#include <dn/flight/flight_config.h>
#include <dn/geo/trajectory.h>
#include <dn/gnss/gnss_data.h>
#include <dn/imu/imu_data.h>
#include <dn/lidar/pairs.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace dn {

/// What a command wants to read of a flight folder.
struct FlightNeeds {
  bool imu = false;
  bool gnss = false;
  bool pairs = false;
  bool trajectory = false;
  /// Read what is there, leave out what is not (dn check).
  bool optional = false;
};

/// A flight folder in memory: SI, radian, body forward-right-down, times continued over a week
/// rollover.
struct Flight {
  FlightConfig config;
  LocalFrame frame{Geodetic{}};
  std::optional<ImuData> imu;
  std::optional<GnssData> gnss;   ///< only epochs inside time_span_s
  std::optional<PairData> pairs;  ///< after pairs: {strategy, ...}; outside time_span_s dropped
  std::optional<Trajectory> trajectory;
  std::optional<Trajectory> initial_guess;  ///< read where present
  std::optional<Trajectory> reference;      ///< read where present
  /// Counts kept and dropped by reason ("gnss rows outside time span": 3), for report.json.
  std::map<std::string, long> counts;
  double read_time_s = 0.0;
};

/// Reads a flight folder. The frame's origin: config, else first GNSS position, else first
/// trajectory position. Throws InvalidConfig when a needed section is missing, InvalidInput for bad
/// data, for no overlap of IMU and GNSS (naming both spans), and for pair epochs outside the IMU
/// data (naming the epoch, file and line).
Flight ReadFlight(const std::filesystem::path& folder, const FlightNeeds& needs);

/// The pairs that a selection keeps: seeded, spread over strip pairs (files) and time.
std::vector<LidarPair> SelectPairs(const std::vector<LidarPair>& pairs,
                                   const PairSelection& selection);

/// Time intervals of strips: those of the config; else clusters of the pairs' epochs (a hole of
/// more than 5 s separates two strips).
std::vector<StripInterval> FindStrips(const Flight& flight);

}  // namespace dn
