#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "byte_source.h"
#include "compression.h"

namespace dn::lidar_internal::laz {

/// Decodes the records of one chunk, in order.
class ChunkDecoder {
 public:
  virtual ~ChunkDecoder() = default;

  /// Decodes the next `count` records. Throws Damaged.
  virtual void Read(std::size_t count, char* records) = 0;
};

/// Starts a chunk of `points` records at the beginning of `source`.
std::unique_ptr<ChunkDecoder> DecodeChunk(const Compression& compression, std::uint64_t points,
                                          ByteSource source);

/// Encodes the records of one chunk, in order.
class ChunkEncoder {
 public:
  virtual ~ChunkEncoder() = default;

  virtual void Append(const char* record) = 0;

  /// Returns the bytes of the chunk. This must be the last call.
  virtual std::string Finish() = 0;
};

std::unique_ptr<ChunkEncoder> EncodeChunk(const Compression& compression);

}  // namespace dn::lidar_internal::laz
