#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::internal {

/// What a glob pattern (*, ?, [..] in any component of the path) names, sorted by path; folders
/// and links that lead back to themselves only where the pattern has none of these. A relative pattern starts at `folder`, whose own name
/// is taken literally.
std::vector<std::filesystem::path> Glob(const std::filesystem::path& folder,
                                        const std::string& pattern);

}  // namespace dn::internal
