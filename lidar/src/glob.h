#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::lidar_internal {

/// Returns the paths that match a glob pattern (*, ?, [..] in any component of the path), sorted.
/// Folders and circular links match only a pattern without wildcards. A relative pattern starts at
/// `folder`; special characters in `folder` itself are literal.
std::vector<std::filesystem::path> Glob(const std::filesystem::path& folder,
                                        const std::string& pattern);

}  // namespace dn::lidar_internal
