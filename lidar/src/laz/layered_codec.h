#pragma once

#include <cstdint>
#include <memory>

#include "chunk_codec.h"

namespace dn::lidar_internal::laz {

/// Chunks in which each attribute has a layer of its own, with its own coder.
///
///   first record | number of points | bytes of each layer | layers
std::unique_ptr<ChunkDecoder> DecodeLayered(const Compression& compression, std::uint64_t points,
                                            ByteSource source);
std::unique_ptr<ChunkEncoder> EncodeLayered(const Compression& compression);

}  // namespace dn::lidar_internal::laz
