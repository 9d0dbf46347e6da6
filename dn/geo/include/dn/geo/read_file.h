#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace dn {

/// Size limit of data files. A day of SBET records at 500 Hz has 6e9 bytes.
inline constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{8} << 30;
/// Size limit of configurations and scenarios.
inline constexpr std::uintmax_t kMaxYamlBytes = std::uintmax_t{1} << 20;

/// Throws InvalidInput, naming what was found instead, unless `file` is a regular file of at most
/// `max_bytes`.
void ExpectRegularFile(const std::filesystem::path& file, std::uintmax_t max_bytes = kMaxFileBytes);

/// Returns whether the path is a symbolic link that leads back to itself, perhaps over other links.
bool IsCircularLink(const std::filesystem::path& path);

/// Returns all bytes of a file. Throws InvalidInput as ExpectRegularFile does, and if the file
/// cannot be read.
std::string ReadWholeFile(const std::filesystem::path& file,
                          std::uintmax_t max_bytes = kMaxFileBytes);

/// Returns the first bytes of a file, fewer if the file is shorter. Throws InvalidInput as
/// ReadWholeFile does.
std::string ReadBeginning(const std::filesystem::path& file, std::size_t bytes);

/// Returns whether a file that begins like this is text in UTF-16.
bool IsUtf16(std::string_view beginning);

/// Returns whether a file that begins like this is binary: it has null bytes, or more than a tenth
/// of its bytes are not ASCII. Text in UTF-16 is not binary.
bool IsBinary(std::string_view beginning);
bool IsBinaryFile(const std::filesystem::path& file);

/// Reads a text file line by line, with only one line in memory.
class LineReader {
 public:
  /// Opens the file and skips a byte order mark. Throws InvalidInput as ReadWholeFile does, and for
  /// text in UTF-16.
  explicit LineReader(std::filesystem::path file);

  /// Reads the next line without its newline; `line` is valid until the next call. Returns false
  /// after the last line. Throws InvalidInput if a line is longer than 64 KiB, because such a file
  /// is not text.
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
