#include "glob.h"

#include <dn/geo/read_file.h>
#include <fnmatch.h>

#include <algorithm>
#include <system_error>

namespace dn::lidar_internal {
namespace {

namespace fs = std::filesystem;

bool IsWild(const std::string& component) {
  return component.find_first_of("*?[") != std::string::npos;
}

/// Returns the entries of `base` that match one component of the pattern.
std::vector<fs::path> Expand(const fs::path& base, const std::string& component) {
  std::error_code none;
  if (!IsWild(component)) {
    const fs::path entry = base / component;
    if (!fs::exists(entry, none)) return {};
    return {entry};
  }
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(base, none)) {
    const std::string name = entry.path().filename().string();
    if (fnmatch(component.c_str(), name.c_str(), FNM_PERIOD) == 0) found.push_back(base / name);
  }
  return found;
}

}  // namespace

std::vector<fs::path> Glob(const fs::path& folder, const std::string& pattern) {
  const fs::path parts(pattern);
  std::vector<fs::path> found{parts.is_absolute() ? parts.root_path() : folder};
  for (const fs::path& part : parts.relative_path()) {
    std::vector<fs::path> next;
    for (const fs::path& base : found) {
      const std::vector<fs::path> entries = Expand(base, part.string());
      next.insert(next.end(), entries.begin(), entries.end());
    }
    found = std::move(next);
  }
  if (IsWild(pattern)) {
    std::erase_if(found, [](const fs::path& file) {
      std::error_code none;
      return fs::is_directory(file, none) || IsCircularLink(file);
    });
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace dn::lidar_internal
