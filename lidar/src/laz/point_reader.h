#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <memory>

#include "chunk_codec.h"
#include "chunk_table.h"

namespace dn::lidar_internal::laz {

/// Reads compressed points in order. Memory does not grow with the file, only with its chunks.
class PointReader {
 public:
  /// The stream and the description must outlive the reader.
  PointReader(std::istream* in, const CompressedPoints* points) : in_(in), points_(points) {}

  /// Decompresses the next `count` records, which must exist. Throws Damaged.
  void Read(std::size_t count, std::size_t record_bytes, char* records);

 private:
  std::istream* in_;
  const CompressedPoints* points_;
  std::unique_ptr<ChunkDecoder> chunk_;
  std::size_t next_chunk_ = 0;
  std::uint64_t left_ = 0;  ///< number of points of the chunk that are not read yet
};

}  // namespace dn::lidar_internal::laz
