#include "point_reader.h"

#include <algorithm>

namespace dn::lidar_internal::laz {

void PointReader::Read(std::size_t count, std::size_t record_bytes, char* records) {
  while (count > 0) {
    if (left_ == 0) {
      const Chunk& chunk = points_->chunks.at(next_chunk_++);
      chunk_ = DecodeChunk(points_->compression, chunk.points,
                           ByteSource(in_, chunk.begin, chunk.begin + chunk.bytes));
      left_ = chunk.points;
    }
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(count, left_));
    chunk_->Read(part, records);
    records += part * record_bytes;
    count -= part;
    left_ -= part;
  }
}

}  // namespace dn::lidar_internal::laz
