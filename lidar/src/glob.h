#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::internal {

/// Regular files that a glob pattern (*, ?, [..] in any component of the path) names, sorted by
/// path. A relative pattern starts at `folder`, whose own name is taken literally.
std::vector<std::filesystem::path> Glob(const std::filesystem::path& folder,
                                        const std::string& pattern);

}  // namespace dn::internal
