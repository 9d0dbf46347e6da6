#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace dn {

/// A file that appears complete or not at all, written in parts: under a hidden name in the same
/// directory until it is published. Every method throws std::filesystem::filesystem_error naming the
/// path (disk full, not writable).
class FileWriter {
 public:
  explicit FileWriter(std::filesystem::path path);
  /// Removes what was written, unless it was published.
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  void Append(std::string_view bytes);

  /// Replaces bytes that were written, from `offset` on.
  void Overwrite(std::uint64_t offset, std::string_view bytes);

  /// Flushes the file to disk and gives it its name. Last call.
  void Publish();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int fd_ = -1;
};

}  // namespace dn
