#include "chunk_table.h"

#include <dn/geo/little_endian.h>

#include <algorithm>

#include "integer_model.h"

namespace dn::lidar_internal::laz {
namespace {

constexpr std::size_t kPointsContext = 0, kBytesContext = 1;
// The symbols of a point take at least 0.0075 bits, because no probability reaches one.
constexpr std::uint64_t kMostPointsPerByte = 2048;

template <class T>
T ReadNumber(ByteSource* source) {
  char bytes[sizeof(T)];
  source->Read(bytes, sizeof(T));
  return LoadLittleEndian<T>(bytes);
}

/// Reads the position of the table. Writers that cannot seek put it at the end of the file.
std::uint64_t ReadTablePosition(std::istream* in, std::uint64_t begin, std::uint64_t file_bytes) {
  const std::uint64_t least = begin + kTablePointerBytes;
  if (file_bytes < least + kTablePointerBytes) throw Damaged("the table of the chunks is missing");
  ByteSource front(in, begin, least);
  auto at = ReadNumber<std::int64_t>(&front);
  if (at == -1) {
    ByteSource back(in, file_bytes - kTablePointerBytes, file_bytes);
    at = ReadNumber<std::int64_t>(&back);
  }
  const auto position = static_cast<std::uint64_t>(at);
  if (at < 0 || position < least || position > file_bytes - kTablePointerBytes) {
    throw Damaged("the table of the chunks is said to begin at byte " + std::to_string(at) +
                  ", but must lie after the points and within the file of " +
                  std::to_string(file_bytes) + " bytes");
  }
  return position;
}

/// Decodes the sizes of the chunks; `source` is the table after its two fixed numbers.
std::vector<Chunk> ReadSizes(ByteSource* source, std::uint32_t count, bool variable) {
  std::vector<Chunk> chunks(count);
  if (count == 0) return chunks;
  Decoder decoder;
  decoder.Start(source);
  IntegerModel<32> numbers(2);
  Chunk before;
  const auto read = [&](std::uint64_t predicted, std::size_t context) {
    return static_cast<std::uint32_t>(
        numbers.Code(decoder, static_cast<std::int32_t>(predicted), 0, context));
  };
  for (Chunk& chunk : chunks) {
    if (variable) chunk.points = read(before.points, kPointsContext);
    chunk.bytes = read(before.bytes, kBytesContext);
    before = chunk;
  }
  return chunks;
}

void CheckChunk(const Chunk& chunk, std::size_t number, std::uint64_t end) {
  const std::string name = "chunk " + std::to_string(number);
  if (chunk.bytes > end - chunk.begin) {
    throw Damaged(name + " extends beyond the table of the chunks");
  }
  if (chunk.points / kMostPointsPerByte > chunk.bytes) {
    throw Damaged(name + " has " + std::to_string(chunk.bytes) + " bytes, too few for " +
                  std::to_string(chunk.points) + " points");
  }
}

}  // namespace

CompressedPoints FindChunks(std::istream* in, const Compression& compression, std::uint64_t begin,
                            std::uint64_t file_bytes, std::uint64_t points) {
  CompressedPoints found{compression, {}, begin};
  if (points == 0) return found;
  if (compression.compressor == Compressor::kPointwise) {
    found.chunks = {{begin, file_bytes - begin, points}};
    CheckChunk(found.chunks.front(), 1, file_bytes);
    return found;
  }
  std::size_t record_bytes = 0;
  for (const Item& item : compression.items) record_bytes += item.bytes;
  const std::uint64_t table_at = ReadTablePosition(in, begin, file_bytes);
  ByteSource table(in, table_at, file_bytes);
  if (const auto version = ReadNumber<std::uint32_t>(&table); version != 0) {
    throw Damaged("version " + std::to_string(version) +
                  " of the table of the chunks is not supported");
  }
  const auto count = ReadNumber<std::uint32_t>(&table);
  if (count > (table_at - begin) / record_bytes) {
    throw Damaged("the table announces " + std::to_string(count) +
                  " chunks, more than the file has room for");
  }
  const bool variable = compression.chunk_points == Compression::kVariable;
  found.chunks = ReadSizes(&table, count, variable);
  found.end = file_bytes - table.left();
  std::uint64_t at = begin + kTablePointerBytes, left = points;
  for (std::size_t i = 0; i < found.chunks.size(); ++i) {
    Chunk& chunk = found.chunks[i];
    chunk.begin = at;
    if (!variable) chunk.points = std::min<std::uint64_t>(left, compression.chunk_points);
    if (chunk.points == 0 || chunk.points > left) {
      throw Damaged("the chunks do not have the " + std::to_string(points) +
                    " points of the header");
    }
    CheckChunk(chunk, i + 1, table_at);
    at += chunk.bytes;
    left -= chunk.points;
  }
  if (left > 0) {
    throw Damaged("the chunks have " + std::to_string(points - left) + " points, but the header " +
                  "announces " + std::to_string(points));
  }
  return found;
}

std::string FormatChunkTable(const std::vector<std::uint32_t>& chunk_bytes) {
  std::string table;
  AppendLittleEndian(std::uint32_t{0}, table);  // version
  AppendLittleEndian(static_cast<std::uint32_t>(chunk_bytes.size()), table);
  if (chunk_bytes.empty()) return table;
  Encoder encoder;
  encoder.Start();
  IntegerModel<32> numbers(2);
  std::uint32_t before = 0;
  for (const std::uint32_t bytes : chunk_bytes) {
    numbers.Code(encoder, static_cast<std::int32_t>(before), static_cast<std::int32_t>(bytes),
                 kBytesContext);
    before = bytes;
  }
  encoder.Finish();
  return table + encoder.bytes();
}

}  // namespace dn::lidar_internal::laz
