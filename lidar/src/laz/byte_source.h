#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace dn::lidar_internal::laz {

/// Thrown for compressed data that cannot be decoded. The message has no file name.
class Damaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bytes of compressed data, from memory or, block by block, from a file.
class ByteSource {
 public:
  ByteSource() = default;

  /// Reads from memory that must outlive the source.
  explicit ByteSource(std::string_view bytes)
      : at_(bytes.data()), end_(bytes.data() + bytes.size()) {}

  /// Reads the bytes from `begin` up to `end` of a file. The stream must outlive the source.
  ByteSource(std::istream* in, std::uint64_t begin, std::uint64_t end);

  ByteSource(ByteSource&&) = default;
  ByteSource& operator=(ByteSource&&) = default;

  /// Returns the next byte. Throws Damaged after the last one.
  std::uint8_t Next() {
    if (at_ == end_) Refill();
    return static_cast<std::uint8_t>(*at_++);
  }

  /// Copies the next bytes. Throws Damaged if there are fewer.
  void Read(char* to, std::size_t count);

  /// Number of bytes that are not read yet.
  std::uint64_t left() const { return left_ + static_cast<std::uint64_t>(end_ - at_); }

 private:
  void Refill();

  std::vector<char> block_;  ///< at_ and end_ survive a move of the vector
  const char* at_ = nullptr;
  const char* end_ = nullptr;
  std::istream* in_ = nullptr;
  std::uint64_t next_ = 0;  ///< position in the file of the byte after the block
  std::uint64_t left_ = 0;  ///< number of bytes after the block
};

}  // namespace dn::lidar_internal::laz
