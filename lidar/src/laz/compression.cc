#include "compression.h"

#include <dn/geo/little_endian.h>

#include "byte_source.h"
#include "point10.h"
#include "point14.h"
#include "wave_packets.h"

namespace dn::lidar_internal::laz {
namespace {

constexpr std::size_t kFixedBytes = 34, kItemBytes = 6;
constexpr std::uint32_t kChunkPoints = 50000;
constexpr std::uint16_t kTimeBytes = 8, kRgbBytes = 6, kRgbNirBytes = 8;
// The version of LASzip whose files have the same compression.
constexpr std::uint8_t kMajor = 3, kMinor = 4;
constexpr std::uint16_t kRevision = 3;

/// Returns the items of a record in the versions that this project writes.
std::vector<Item> MakeItems(int format, std::size_t record_bytes) {
  std::vector<Item> items;
  std::size_t rest = record_bytes;
  const bool layered = format >= 6;
  const auto add = [&](ItemType type, std::size_t bytes, std::uint16_t version) {
    items.push_back({type, static_cast<std::uint16_t>(bytes), version});
    rest -= bytes;
  };
  if (layered) {
    add(ItemType::kPoint14, Point14Fields::kBytes, 3);
    if (format == 7) add(ItemType::kRgb14, kRgbBytes, 3);
    if (format == 8 || format == 10) add(ItemType::kRgbNir14, kRgbNirBytes, 3);
    if (format >= 9) add(ItemType::kWavePacket14, WavePacket::kBytes, 3);
  } else {
    add(ItemType::kPoint10, Point10Fields::kBytes, 2);
    if (format != 0 && format != 2) add(ItemType::kGpsTime11, kTimeBytes, 2);
    if (format == 2 || format == 3 || format == 5) add(ItemType::kRgb12, kRgbBytes, 2);
    if (format >= 4) add(ItemType::kWavePacket13, WavePacket::kBytes, 1);
  }
  if (rest > 0) add(layered ? ItemType::kByte14 : ItemType::kByte, rest, layered ? 3 : 2);
  return items;
}

std::string Describe(const Item& item) {
  return "type " + std::to_string(static_cast<int>(item.type)) + ", version " +
         std::to_string(item.version) + ", " + std::to_string(item.bytes) + " bytes";
}

void CheckItem(const Item& item, const Item& expected, bool layered) {
  const bool known =
      layered ? item.version >= 2 && item.version <= 4 : item.version == 1 || item.version == 2;
  if (item.type == expected.type && item.bytes == expected.bytes && known) return;
  throw Damaged("the compression has an item of " + Describe(item) +
                " where the point format needs one of " + Describe(expected));
}

}  // namespace

Compression MakeCompression(int point_format, std::size_t record_bytes) {
  const bool layered = point_format >= 6;
  return {layered ? Compressor::kLayered : Compressor::kPointwiseChunked, kChunkPoints,
          MakeItems(point_format, record_bytes)};
}

Compression ParseCompression(std::string_view content, int point_format, std::size_t record_bytes) {
  if (content.size() < kFixedBytes) {
    throw Damaged("the record of the compression has " + std::to_string(content.size()) +
                  " bytes, but needs at least " + std::to_string(kFixedBytes));
  }
  const auto compressor = LoadLittleEndian<std::uint16_t>(content.data());
  const auto coder = LoadLittleEndian<std::uint16_t>(content.data() + 2);
  const bool layered = point_format >= 6;
  if (coder != 0 || (layered ? compressor != 3 : compressor != 1 && compressor != 2)) {
    throw Damaged("compressor " + std::to_string(compressor) + " with coder " +
                  std::to_string(coder) + " is not supported for point format " +
                  std::to_string(point_format));
  }
  Compression compression = MakeCompression(point_format, record_bytes);
  compression.compressor = static_cast<Compressor>(compressor);
  compression.chunk_points = LoadLittleEndian<std::uint32_t>(content.data() + 12);
  if (compression.chunk_points == 0) compression.chunk_points = Compression::kVariable;
  const std::size_t count = LoadLittleEndian<std::uint16_t>(content.data() + 32);
  if (count != compression.items.size() || content.size() < kFixedBytes + count * kItemBytes) {
    throw Damaged("the compression has " + std::to_string(count) +
                  " items, but records of this format have " +
                  std::to_string(compression.items.size()));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const char* at = content.data() + kFixedBytes + i * kItemBytes;
    const Item item{static_cast<ItemType>(LoadLittleEndian<std::uint16_t>(at)),
                    LoadLittleEndian<std::uint16_t>(at + 2),
                    LoadLittleEndian<std::uint16_t>(at + 4)};
    CheckItem(item, compression.items[i], layered);
    compression.items[i] = item;
  }
  return compression;
}

std::string FormatCompression(const Compression& compression) {
  constexpr std::uint64_t kUnused = ~std::uint64_t{0};
  std::string content;
  AppendLittleEndian(static_cast<std::uint16_t>(compression.compressor), content);
  AppendLittleEndian(std::uint16_t{0}, content);  // arithmetic coder
  AppendLittleEndian(kMajor, content);
  AppendLittleEndian(kMinor, content);
  AppendLittleEndian(kRevision, content);
  AppendLittleEndian(std::uint32_t{0}, content);  // options
  AppendLittleEndian(compression.chunk_points, content);
  AppendLittleEndian(kUnused, content);  // number of special records
  AppendLittleEndian(kUnused, content);  // position of special records
  AppendLittleEndian(static_cast<std::uint16_t>(compression.items.size()), content);
  for (const Item& item : compression.items) {
    AppendLittleEndian(static_cast<std::uint16_t>(item.type), content);
    AppendLittleEndian(item.bytes, content);
    AppendLittleEndian(item.version, content);
  }
  return content;
}

}  // namespace dn::lidar_internal::laz
