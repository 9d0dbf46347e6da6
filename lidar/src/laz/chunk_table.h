#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <vector>

#include "compression.h"

namespace dn::lidar_internal::laz {

/// Length of the position of the table, which stands before the first chunk.
inline constexpr std::uint64_t kTablePointerBytes = 8;

struct Chunk {
  std::uint64_t begin = 0;  ///< position of its first byte in the file
  std::uint64_t bytes = 0;
  std::uint64_t points = 0;
};

/// The compressed points of a file.
struct CompressedPoints {
  Compression compression;
  std::vector<Chunk> chunks;
  /// Position after the chunks and their table. Without chunks: that of the first point.
  std::uint64_t end = 0;
};

/// Reads the table of the chunks of a file whose points begin at byte `begin`. Throws Damaged if
/// the table contradicts `points` or the size of the file.
CompressedPoints FindChunks(std::istream* in, const Compression& compression, std::uint64_t begin,
                            std::uint64_t file_bytes, std::uint64_t points);

/// Formats the table of chunks with the same number of points.
std::string FormatChunkTable(const std::vector<std::uint32_t>& chunk_bytes);

}  // namespace dn::lidar_internal::laz
