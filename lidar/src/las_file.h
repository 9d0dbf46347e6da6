#pragma once

#include <dn/error.h>
#include <dn/lidar/strip_io.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dn::internal {

/// Bytes of the header and of the records, from the ASPRS LAS specification 1.4 R15.
namespace las {
inline constexpr std::size_t kEncodingAt = 6, kVersionAt = 24, kSoftwareAt = 58,
                             kHeaderBytesAt = 94, kPointsAt = 96, kVlrCountAt = 100,
                             kFormatAt = 104, kRecordBytesAt = 105, kLegacyCountAt = 107,
                             kLegacyReturnsAt = 111, kScaleAt = 131, kOffsetAt = 155,
                             kBoundsAt = 179, kWaveformAt = 227, kEvlrAt = 235, kEvlrCountAt = 243,
                             kCountAt = 247, kReturnsAt = 255;
inline constexpr std::size_t kIntensityAt = 12, kReturnAt = 14, kLegacyClassAt = 15, kClassAt = 16;
inline constexpr std::size_t kVlrHeaderBytes = 54, kEvlrHeaderBytes = 60, kDescriptorBytes = 192;
inline constexpr std::size_t kLegacyReturns = 5, kReturns = 15;
inline constexpr std::uint16_t kExtraBytesId = 4;
/// The record of the boresight that the points were computed with: roll, pitch, yaw [deg, FRD] as
/// three doubles.
inline constexpr std::string_view kBoresightUser = "dn";
inline constexpr std::uint16_t kBoresightId = 1;
inline constexpr std::size_t kBoresightBytes = 24;
}  // namespace las

/// One of the attributes behind the standard part of a record.
struct ExtraDimension {
  std::string name;
  int type = 0;        ///< of the specification, 0: bytes without a meaning
  std::size_t at = 0;  ///< first byte in the record
  std::size_t bytes = 0;
  double scale = 1.0;
  double offset = 0.0;
};

/// A variable length record: its header and content lie in LasFile::head.
struct Vlr {
  std::string user;
  std::uint16_t id = 0;
  std::size_t at = 0;     ///< first byte of its header
  std::size_t bytes = 0;  ///< of its content
};

/// All that a LAS file says but its points, checked.
struct LasFile {
  std::filesystem::path path;
  std::string head;  ///< everything before the first point
  int minor = 0;     ///< version 1.minor
  int format = 0;    ///< of the points
  std::size_t header_bytes = 0;
  std::size_t record_bytes = 0;
  std::uint64_t points = 0;
  std::uint64_t file_bytes = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::optional<std::size_t> time_at;  ///< first byte of the GPS time in a record
  bool adjusted_time = false;          ///< GPS time is "adjusted standard", else seconds of week
  std::size_t source_at = 0;
  std::vector<Vlr> vlrs;
  std::vector<ExtraDimension> extra;
  std::size_t described_bytes = 0;  ///< of a record: standard part and described extra bytes
  StripCrs crs;
  std::optional<Eigen::Vector3d> boresight_rad;  ///< recorded by a writer of this program

  std::uint64_t points_begin() const { return head.size(); }
  std::uint64_t points_end() const { return head.size() + points * record_bytes; }
  const ExtraDimension* Find(std::string_view name) const;
  std::string_view Content(const Vlr& vlr) const {
    return std::string_view(head).substr(vlr.at + las::kVlrHeaderBytes, vlr.bytes);
  }
};

/// Returns of the same pulse after that of a record.
std::uint8_t ReturnsAfter(const LasFile& las, const char* record);

/// Class of a record, without its flags.
std::uint8_t ClassOf(const LasFile& las, const char* record);

/// Reads everything but the points.
LasFile ReadLasFile(const std::filesystem::path& file);

/// Bytes of a value of one type; 0 for a type that there is not.
std::size_t BytesOfType(int type);

/// The attributes that the record "extra bytes" describes, behind `base_bytes` of the standard part.
/// Throws InvalidInput at `where` when they do not fit into the record.
std::vector<ExtraDimension> ParseExtraBytes(std::string_view content, std::size_t base_bytes,
                                            std::size_t record_bytes, const FileLocation& where);

/// Description of an attribute; `options` of one without a meaning (type 0): its bytes.
std::string FormatDescriptor(int type, std::size_t options, const std::string& name,
                             const std::string& description);

/// A variable length record.
std::string FormatVlr(std::string_view user, std::uint16_t id, std::string_view title,
                      std::string_view content);

/// The variable length record of these descriptions.
std::string FormatExtraBytes(const std::string& descriptors);

/// Value of an attribute of a single number.
double ValueOf(const ExtraDimension& dimension, const char* record);

/// Coordinate system by GeoTIFF keys: content of the records 34735 and 34737.
StripCrs ParseGeoTiff(std::string_view directory, std::string_view ascii,
                      const FileLocation& where);

/// Coordinate system by well-known text, of 2001 or 2019.
StripCrs ParseWkt(std::string_view text, const FileLocation& where);

}  // namespace dn::internal
