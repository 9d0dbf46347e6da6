#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace dn {

/// A file that appears completely or not at all. It is written in parts under a hidden name in the
/// same directory, and renamed when it is published. Every method throws
/// std::filesystem::filesystem_error naming the path (for example disk full, not writable).
class FileWriter {
 public:
  explicit FileWriter(std::filesystem::path path);
  /// Deletes the file unless it was published.
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  void Append(std::string_view bytes);

  /// Replaces bytes that were already written, from `offset` on.
  void Overwrite(std::uint64_t offset, std::string_view bytes);

  /// Flushes the file to disk and renames it to its final name. No other method may be called
  /// afterwards.
  void Publish();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int fd_ = -1;
};

}  // namespace dn
