#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dn::lidar_internal::laz {

/// Order of the compressed values in the file.
enum class Compressor : std::uint16_t {
  kPointwise = 1,         ///< point by point, without chunks
  kPointwiseChunked = 2,  ///< chunks, point by point
  kLayered = 3,           ///< chunks, attribute by attribute
};

/// Parts of a record that are coded together. The numbers are those of the file.
enum class ItemType : std::uint16_t {
  kByte = 0,
  kPoint10 = 6,
  kGpsTime11 = 7,
  kRgb12 = 8,
  kWavePacket13 = 9,
  kPoint14 = 10,
  kRgb14 = 11,
  kRgbNir14 = 12,
  kWavePacket14 = 13,
  kByte14 = 14,
};

struct Item {
  ItemType type = ItemType::kByte;
  std::uint16_t bytes = 0;
  std::uint16_t version = 0;
};

/// How the points of a file are compressed: the content of its record "laszip encoded", 22204.
struct Compression {
  static constexpr std::string_view kUser = "laszip encoded";
  static constexpr std::uint16_t kId = 22204;
  static constexpr std::uint32_t kVariable = 0xFFFFFFFFu;

  Compressor compressor = Compressor::kPointwiseChunked;
  std::uint32_t chunk_points = kVariable;  ///< kVariable: the table of chunks has the numbers
  std::vector<Item> items;                 ///< in the order of the record
};

/// Returns the compression with which this project writes records of a point format.
Compression MakeCompression(int point_format, std::size_t record_bytes);

/// Parses the content of the record. Throws Damaged if it does not fit the points, or if this
/// project cannot decode such a file.
Compression ParseCompression(std::string_view content, int point_format, std::size_t record_bytes);

/// Formats the content of the record.
std::string FormatCompression(const Compression& compression);

}  // namespace dn::lidar_internal::laz
