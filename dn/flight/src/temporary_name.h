#pragma once

#include <filesystem>

namespace dn::internal {

/// A hidden sibling of `path` that no other process or thread uses: on the same file system, so
/// that a rename onto `path` is atomic.
std::filesystem::path TemporarySibling(const std::filesystem::path& path);

}  // namespace dn::internal
