#pragma once

#include <dn/files/flight_config.h>
#include <dn/lidar/mounting.h>
#include <dn/lidar/strip_io.h>
#include <dn/lidar/vector_origin.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// Returns the point clouds of a flight sorted by name: the .las, .laz and .txt files in the folder
/// `strips` of its data. Circular links are left out. The list is empty if there is no such folder.
std::vector<std::filesystem::path> FindStripFiles(const std::filesystem::path& flight_folder);

/// Returns the point clouds of one scanner of a flight: those in `strips_SCANNER`, or in `strips`
/// for an empty name.
std::vector<std::filesystem::path> FindStripFiles(const std::filesystem::path& flight_folder,
                                                  const std::string& scanner);

/// Returns the point clouds of the scanners of a configuration: those in the folder `strips`, or in
/// `strips_NAME` for a scanner of a list.
std::vector<std::filesystem::path> FindStripFiles(const FlightConfig& config);

/// Returns the point clouds of scanner k of a configuration.
std::vector<std::filesystem::path> FindStripFiles(const FlightConfig& config, std::size_t scanner);

/// Returns the files of FindStripFiles; throws InvalidInput if there are none.
std::vector<std::filesystem::path> RequireStripFiles(const FlightConfig& config);

/// Returns the name of the coordinate system that the headers of all strips of a flight state.
/// Empty if one has none, if they differ, or if one cannot be read.
std::string FindStripsCrs(const FlightConfig& config);

/// Compares the coordinate system in the header of a strip with strips_crs of flight.yaml. Throws
/// InvalidConfig if they contradict each other, with the value to write. Returns a note for the
/// user; empty if there is nothing to note.
std::string CheckStripCrs(const StripCrs& said, const std::string& strips_crs,
                          const std::filesystem::path& file);

/// The georeferencing that gave the points of strips their coordinates.
struct StripGeoreferencing {
  Mounting mounting;                            ///< its boresight is used if no other is known
  std::optional<Eigen::Vector3d> declared_rad;  ///< lidar.georeferenced_with of flight.yaml
};

/// Returns the georeferencing of the strips of a flight, which must have a section `lidar`.
StripGeoreferencing StripsGeoreferencing(const FlightConfig& config);

/// Returns the origin of a strip's laser vectors. It is the file itself, else the boresight that it
/// records, else the declared one, else that of the mounting. Throws InvalidConfig if the recorded
/// and the declared boresight differ by more than 1e-6 deg.
VectorOrigin FindVectorOrigin(const StripReader& strip, const StripGeoreferencing& made_with,
                              const std::filesystem::path& file);

/// Returns a warning about computed laser vectors whose boresight is only assumed; empty for other
/// vectors.
std::string VectorWarning(const VectorOrigin& origin, const std::string& strip);

}  // namespace dn
