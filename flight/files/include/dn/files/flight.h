#pragma once

#include <dn/files/control.h>
#include <dn/files/flight_config.h>
#include <dn/files/map_gnss.h>
#include <dn/files/surfaces.h>
#include <dn/files/ties.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>
#include <dn/lidar/pairs.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// The parts of a flight folder that a command reads.
struct FlightNeeds {
  bool imu = false;
  bool gnss = false;
  bool pairs = false;
  bool trajectory = false;
  bool control = false;  ///< reads the control files, if there are any
  bool ties = false;     ///< reads the tie points, if there are any
  /// Reads the parts that exist and leaves out missing ones (dn check).
  bool optional = false;
  /// With two or more, the reference is read in parallel with the inertial data.
  int threads = 1;
};

/// A flight folder in memory: SI, radian, body forward-right-down, and times that continue over a
/// week rollover.
struct Flight {
  FlightConfig config;
  LocalFrame frame{Geodetic{}};
  std::optional<ImuData> imu;
  std::optional<MapGnss> gnss;  ///< only epochs inside time_span_s
  /// Pairs after the selection by lidar.pairs, without those outside time_span_s.
  std::optional<PairData> pairs;
  /// The strips found from all pairs before the selection (FindStrips).
  std::vector<StripInterval> pair_strips;
  /// Surface pairs as planes of unknown position, each with its two returns (ReadSurfaces). Those
  /// outside the IMU data or time_span_s, or in gaps, are left out.
  std::optional<ControlData> surfaces;
  std::optional<ControlData> control;  ///< without returns in gaps of the IMU data
  std::optional<TieData> ties;         ///< without returns outside the IMU data or in their gaps
  std::optional<Trajectory> trajectory;
  std::optional<Trajectory> initial_guess;  ///< read if present
  std::optional<Trajectory> reference;      ///< read if present
  /// Numbers of used and dropped data by reason ("gnss rows outside time span": 3), for
  /// report.json.
  std::map<std::string, long> counts;
  double read_time_s = 0.0;
};

/// Reads a flight folder. The origin of the map frame is that of the configuration, else the first
/// position of the GNSS file, else the first trajectory position. The GNSS file is used even if
/// GNSS is not requested. If flight.yaml does not set the file names, trajectory.txt and
/// lidar/*.txt are also accepted. A trajectory under its default name needs no section.
///
/// GNSS epochs outside time_span_s or the IMU data are dropped and counted. So are pairs outside
/// time_span_s, repeated pairs, and GNSS epochs and pairs in gaps of the IMU data or the
/// trajectory.
///
/// Throws InvalidConfig if the folder, flight.yaml or a needed section is missing. Throws
/// InvalidInput
/// - for a missing file (with its path and key) and for bad data;
/// - if IMU and GNSS do not overlap (with both spans);
/// - for pair epochs outside the IMU data or trajectory that was read (with the epoch, file and
///   line);
/// - if more than half of the pairs are in gaps.
///
/// With `optional`, pairs must be inside one of the two; those outside the other and those in gaps
/// are counted and kept.
Flight ReadFlight(const std::filesystem::path& folder, const FlightNeeds& needs);

/// Reads a flight with a given configuration, for example with another trajectory file. Relative
/// file names start at config.folder.
Flight ReadFlight(const FlightConfig& config, const FlightNeeds& needs);

/// Returns the selected pairs in their order; the same seed gives the same selection.
///   max: `count` pairs in equal shares of the files (strip pairs). A file is divided in order of
///        t_i into as many equal parts as its share; one random pair of each part is kept.
///   freq: per file, the pair nearest to each tick of a raster of freq_hz that starts at its first
///        t_i, if a pair lies within half a period.
///   time_window: per file, one random pair of each window of window_s that contains pairs.
/// Throws InvalidConfig if the parameter of the strategy is missing or not positive.
std::vector<LidarPair> SelectPairs(const std::vector<LidarPair>& pairs,
                                   const PairSelection& selection);

/// Returns the time intervals of the strips: those of the configuration, or else clusters of the
/// pair epochs. Without both, they are the straight legs of the trajectory of at least 10 s. Gaps
/// of more than 5 s separate clusters, which include all pairs if ReadFlight read them.
std::vector<StripInterval> FindStrips(const Flight& flight);

/// Returns the straight legs of a trajectory of at least 10 s.
std::vector<StripInterval> FindStrips(const Trajectory& trajectory);

}  // namespace dn
