#pragma once

#include <dn/lidar/strip_io.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// Returns the point clouds of a flight sorted by name: the .las, .laz and .txt files in the folder
/// `strips` of its data. Circular links are left
/// out. The list is empty if there is no such folder.
std::vector<std::filesystem::path> FindStripFiles(const std::filesystem::path& flight_folder);

/// Returns the same files; throws InvalidInput if there are none.
std::vector<std::filesystem::path> NeedStripFiles(const std::filesystem::path& flight_folder);

/// Compares the coordinate system in the header of a strip with strips_crs of flight.yaml. Throws
/// InvalidConfig if they contradict each other, with the value to write. Returns a note for the
/// user; empty if there is nothing to note.
std::string CheckStripCrs(const StripCrs& said, const std::string& strips_crs,
                          const std::filesystem::path& file);

}  // namespace dn
