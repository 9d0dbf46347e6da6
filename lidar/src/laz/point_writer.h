#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "chunk_codec.h"
#include "chunk_table.h"

namespace dn::lidar_internal::laz {

/// Compresses points. The caller writes the bytes that become ready, and at the end replaces the
/// first eight of them by table_at().
class PointWriter {
 public:
  /// `begin` is the position of the first byte in the file.
  PointWriter(Compression compression, std::uint64_t begin);

  /// Compresses a number of whole records.
  void Append(std::string_view records);

  /// Completes the last chunk and the table of the chunks.
  void Finish();

  /// Returns the bytes that became ready since the last call.
  std::string TakeBytes() { return std::exchange(ready_, {}); }

  /// Position of the table of the chunks. It is final after Finish.
  std::uint64_t table_at() const { return table_at_; }

 private:
  void FinishChunk();

  Compression compression_;
  std::size_t record_bytes_ = 0;
  std::string ready_;
  std::uint64_t table_at_;
  std::unique_ptr<ChunkEncoder> chunk_;
  std::uint32_t points_ = 0;  ///< of the unfinished chunk
  std::vector<std::uint32_t> chunk_bytes_;
};

}  // namespace dn::lidar_internal::laz
