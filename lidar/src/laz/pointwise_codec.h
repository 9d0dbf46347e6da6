#pragma once

#include <memory>

#include "chunk_codec.h"

namespace dn::lidar_internal::laz {

/// Chunks in which all items of a point follow each other, with a single coder.
std::unique_ptr<ChunkDecoder> DecodePointwise(const Compression& compression, ByteSource source);
std::unique_ptr<ChunkEncoder> EncodePointwise(const Compression& compression);

}  // namespace dn::lidar_internal::laz
