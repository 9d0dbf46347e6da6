#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace dn {

/// Larger data files are refused: a day of SBET records at 500 Hz has 6e9 bytes.
inline constexpr std::uintmax_t kMostFileBytes = std::uintmax_t{8} << 30;
/// Larger configurations and scenarios are refused.
inline constexpr std::uintmax_t kMostYamlBytes = std::uintmax_t{1} << 20;

/// Throws InvalidInput, saying what stands there instead, unless `file` is a regular file of at
/// most `most_bytes`.
void ExpectRegularFile(const std::filesystem::path& file,
                       std::uintmax_t most_bytes = kMostFileBytes);

/// Whether the path is a symbolic link that leads, perhaps over others, back to itself.
bool IsCircularLink(const std::filesystem::path& path);

/// All bytes of a file. Throws InvalidInput as ExpectRegularFile does, and when it cannot be read.
std::string ReadWholeFile(const std::filesystem::path& file,
                          std::uintmax_t most_bytes = kMostFileBytes);

/// The lines of a file one by one, without holding more than one of them.
class LineReader {
 public:
  /// Throws InvalidInput as ReadWholeFile does.
  explicit LineReader(std::filesystem::path file);

  /// The next line without its newline, valid until the next call; false after the last. Throws
  /// InvalidInput when a line is longer than 64 KiB: such a file is no text.
  bool Next(std::string_view* line);

  long line() const { return line_; }  ///< number of the last line, from 1

 private:
  bool ReadMore();

  std::filesystem::path file_;
  std::ifstream in_;
  std::string buffer_;
  std::size_t begin_ = 0;
  long line_ = 0;
};

}  // namespace dn
