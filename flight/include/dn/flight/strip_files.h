#pragma once

#include <dn/lidar/strip_io.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// The point clouds of a flight: the .las, .laz and .txt files in the folder `strips` of its data,
/// sorted by name; none where there is no such folder. Links that lead back to themselves are left
/// out.
std::vector<std::filesystem::path> FindStripFiles(const std::filesystem::path& flight_folder);

/// The same; throws InvalidInput where there are none.
std::vector<std::filesystem::path> NeedStripFiles(const std::filesystem::path& flight_folder);

/// Compares what a strip's file says of its coordinate system with strips_crs of flight.yaml.
/// Throws InvalidConfig where they contradict each other, saying what to write. Returns what a user
/// should know beside it; empty: nothing.
std::string CheckStripCrs(const StripCrs& said, const std::string& strips_crs,
                          const std::filesystem::path& file);

}  // namespace dn
