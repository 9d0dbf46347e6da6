#pragma once

#include <filesystem>
#include <system_error>

namespace dn::files_internal {

/// Returns whether the path exists, including files that cannot be read.
inline bool IsThere(const std::filesystem::path& path) {
  std::error_code none;
  return std::filesystem::status(path, none).type() != std::filesystem::file_type::not_found;
}

}  // namespace dn::files_internal
