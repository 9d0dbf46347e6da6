#include <dn/geo/little_endian.h>

#include "las_file.h"

namespace dn::lidar_internal {
namespace {

// Byte positions within a descriptor.
constexpr std::size_t kTypeAt = 2, kOptionsAt = 3, kNameAt = 4, kNameBytes = 32, kScaleAt = 112,
                      kOffsetAt = 136, kDescriptionAt = 160, kDescriptionBytes = 32;
constexpr int kHasScale = 8, kHasOffset = 16;

ExtraDimension ParseDescriptor(const char* bytes) {
  ExtraDimension dimension;
  dimension.type = static_cast<unsigned char>(bytes[kTypeAt]);
  const int options = static_cast<unsigned char>(bytes[kOptionsAt]);
  const std::string_view name(bytes + kNameAt, kNameBytes);
  dimension.name = name.substr(0, name.find('\0'));
  if (dimension.type == 0) {
    dimension.bytes = static_cast<std::size_t>(options);
    return dimension;
  }
  dimension.bytes = ExtraTypeBytes(dimension.type);
  if ((options & kHasScale) != 0) dimension.scale = LoadLittleEndian<double>(bytes + kScaleAt);
  if ((options & kHasOffset) != 0) dimension.offset = LoadLittleEndian<double>(bytes + kOffsetAt);
  return dimension;
}

double RawValue(int type, const char* bytes) {
  switch (type) {
    case 1:
      return LoadLittleEndian<std::uint8_t>(bytes);
    case 2:
      return LoadLittleEndian<std::int8_t>(bytes);
    case 3:
      return LoadLittleEndian<std::uint16_t>(bytes);
    case 4:
      return LoadLittleEndian<std::int16_t>(bytes);
    case 5:
      return LoadLittleEndian<std::uint32_t>(bytes);
    case 6:
      return LoadLittleEndian<std::int32_t>(bytes);
    case 7:
      return static_cast<double>(LoadLittleEndian<std::uint64_t>(bytes));
    case 8:
      return static_cast<double>(LoadLittleEndian<std::int64_t>(bytes));
    case 9:
      return LoadLittleEndian<float>(bytes);
    default:
      return LoadLittleEndian<double>(bytes);
  }
}

}  // namespace

std::size_t ExtraTypeBytes(int type) {
  constexpr std::array<std::size_t, 11> kBytes{0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  if (type < 1 || type > 30) return 0;
  // Older versions had pairs and triples.
  const auto values = static_cast<std::size_t>((type - 1) / 10 + 1);
  return values * kBytes[static_cast<std::size_t>((type - 1) % 10 + 1)];
}

std::vector<ExtraDimension> ParseExtraBytes(std::string_view content, std::size_t base_bytes,
                                            std::size_t record_bytes, const FileLocation& where) {
  if (content.size() % las::kDescriptorBytes != 0) {
    throw InvalidInput("LAS header: the record of the extra bytes has " +
                           std::to_string(content.size()) +
                           " bytes, which is not a multiple of 192",
                       where);
  }
  std::vector<ExtraDimension> dimensions;
  std::size_t at = base_bytes;
  for (std::size_t i = 0; i < content.size(); i += las::kDescriptorBytes) {
    ExtraDimension dimension = ParseDescriptor(content.data() + i);
    if (dimension.type > 30) {
      throw InvalidInput("LAS header: extra bytes number " + std::to_string(dimensions.size() + 1) +
                             " have the unknown type " + std::to_string(dimension.type),
                         where);
    }
    dimension.at = at;
    at += dimension.bytes;
    dimensions.push_back(std::move(dimension));
  }
  if (at > record_bytes) {
    throw InvalidInput(
        "LAS header: a record has " + std::to_string(record_bytes) +
            " bytes (byte 105), but its standard part and the described extra bytes need " +
            std::to_string(at),
        where);
  }
  return dimensions;
}

std::string FormatDescriptor(int type, std::size_t options, const std::string& name,
                             const std::string& description) {
  std::string bytes(las::kDescriptorBytes, '\0');
  bytes[kTypeAt] = static_cast<char>(type);
  bytes[kOptionsAt] = static_cast<char>(options);
  name.copy(bytes.data() + kNameAt, kNameBytes);
  description.copy(bytes.data() + kDescriptionAt, kDescriptionBytes);
  return bytes;
}

std::string FormatVlr(std::string_view user, std::uint16_t id, std::string_view title,
                      std::string_view content) {
  constexpr std::size_t kUserBytes = 16, kTitleBytes = 32;
  std::string record(las::kVlrHeaderBytes, '\0');
  user.copy(record.data() + 2, kUserBytes);
  StoreLittleEndian(id, record.data() + 18);
  StoreLittleEndian(static_cast<std::uint16_t>(content.size()), record.data() + 20);
  title.copy(record.data() + 22, kTitleBytes);
  return record.append(content);
}

std::string FormatExtraBytes(const std::string& descriptors) {
  return FormatVlr("LASF_Spec", las::kExtraBytesId, "Extra Bytes", descriptors);
}

double BlockValue(const ExtraDimension& dimension, const char* record) {
  return RawValue(dimension.type, record + dimension.at) * dimension.scale + dimension.offset;
}

}  // namespace dn::lidar_internal
