#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Writes a file so that it appears complete or not at all: to a temporary name in the same
/// directory, flushed to disk, then renamed. Throws std::filesystem::filesystem_error naming the
/// path (disk full, not writable); nothing is left behind then.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view content);

/// Collects the files of a result directory and publishes them together: Add stages a file, Commit
/// renames all of them; without Commit the destructor removes what was staged. Makes the directory
/// if absent.
class OutputDirectory {
 public:
  explicit OutputDirectory(std::filesystem::path directory);
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  /// Stages a file; `name` may contain one level of sub-directory ("lidar/1_2.txt").
  void Add(const std::string& name, std::string_view content);

  /// Makes every staged file visible.
  void Commit();

  const std::filesystem::path& path() const { return directory_; }

 private:
  std::filesystem::path directory_;
  std::filesystem::path staging_;
  std::vector<std::string> names_;
};

}  // namespace dn
