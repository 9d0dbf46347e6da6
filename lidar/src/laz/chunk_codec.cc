#include "chunk_codec.h"

#include <utility>

#include "layered_codec.h"
#include "pointwise_codec.h"

namespace dn::lidar_internal::laz {

std::unique_ptr<ChunkDecoder> DecodeChunk(const Compression& compression, std::uint64_t points,
                                          ByteSource source) {
  if (compression.compressor == Compressor::kLayered) {
    return DecodeLayered(compression, points, std::move(source));
  }
  return DecodePointwise(compression, std::move(source));
}

std::unique_ptr<ChunkEncoder> EncodeChunk(const Compression& compression) {
  if (compression.compressor == Compressor::kLayered) return EncodeLayered(compression);
  return EncodePointwise(compression);
}

}  // namespace dn::lidar_internal::laz
