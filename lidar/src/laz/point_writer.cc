#include "point_writer.h"

namespace dn::lidar_internal::laz {

PointWriter::PointWriter(Compression compression, std::uint64_t begin)
    : compression_(std::move(compression)),
      ready_(kTablePointerBytes, '\0'),
      table_at_(begin + kTablePointerBytes) {
  for (const Item& item : compression_.items) record_bytes_ += item.bytes;
}

void PointWriter::Append(std::string_view records) {
  for (; !records.empty(); records.remove_prefix(record_bytes_)) {
    if (!chunk_) chunk_ = EncodeChunk(compression_);
    chunk_->Append(records.data());
    if (++points_ == compression_.chunk_points) FinishChunk();
  }
}

void PointWriter::FinishChunk() {
  const std::string bytes = chunk_->Finish();
  chunk_bytes_.push_back(static_cast<std::uint32_t>(bytes.size()));
  table_at_ += bytes.size();
  ready_ += bytes;
  chunk_.reset();
  points_ = 0;
}

void PointWriter::Finish() {
  if (chunk_) FinishChunk();
  ready_ += FormatChunkTable(chunk_bytes_);
}

}  // namespace dn::lidar_internal::laz
