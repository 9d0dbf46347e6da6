#pragma once

#include <filesystem>

namespace dn::internal {

/// A hidden sibling of `path` whose name nobody can foresee: on the same file system, so that a
/// rename onto `path` is atomic.
std::filesystem::path TemporarySibling(const std::filesystem::path& path);

}  // namespace dn::internal
