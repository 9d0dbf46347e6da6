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

#include "laz/laz.h"

namespace dn::lidar_internal {

/// Byte positions in the header and in the records, from the ASPRS LAS specification 1.4 R15.
namespace las {
inline constexpr std::size_t kEncodingAt = 6, kVersionAt = 24, kSoftwareAt = 58,
                             kHeaderBytesAt = 94, kPointsAt = 96, kVlrCountAt = 100,
                             kFormatAt = 104, kRecordBytesAt = 105, kLegacyCountAt = 107,
                             kLegacyReturnsAt = 111, kScaleAt = 131, kOffsetAt = 155,
                             kBoundsAt = 179, kWaveformAt = 227, kEvlrAt = 235, kEvlrCountAt = 243,
                             kCountAt = 247, kReturnsAt = 255;
inline constexpr std::size_t kIntensityAt = 12, kReturnAt = 14, kLegacyClassAt = 15, kFlagsAt = 15,
                             kClassAt = 16;
inline constexpr std::size_t kVlrHeaderBytes = 54, kEvlrHeaderBytes = 60, kDescriptorBytes = 192;
inline constexpr std::size_t kRecordUserAt = 2, kRecordUserBytes = 16;
inline constexpr std::size_t kLegacyReturns = 5, kReturns = 15;
inline constexpr std::uint16_t kExtraBytesId = 4;
/// The record of the boresight that the points were computed with: roll, pitch, yaw [deg, FRD] as
/// three doubles.
inline constexpr std::string_view kBoresightUser = "dn";
inline constexpr std::uint16_t kBoresightId = 1;
inline constexpr std::size_t kBoresightBytes = 24;
/// The records of COPC, which contain positions of points in the file.
inline constexpr std::string_view kIndexUser = "copc";
/// The record that replaces one whose content is no longer valid.
inline constexpr std::string_view kSupersededUser = "LASF_Spec";
inline constexpr std::uint16_t kSupersededId = 7;
/// The bit of the point format that marks compressed points.
inline constexpr std::uint8_t kCompressedBit = 0x80;
}  // namespace las

/// One attribute of a record after its standard part.
struct ExtraDimension {
  std::string name;
  int type = 0;        ///< data type of the LAS specification; 0: bytes without a defined meaning
  std::size_t at = 0;  ///< position of its first byte in the record
  std::size_t bytes = 0;
  double scale = 1.0;
  double offset = 0.0;
};

/// Variable length record; its header and content are stored in LasFile::head.
struct Vlr {
  std::string user;
  std::uint16_t id = 0;
  std::size_t at = 0;     ///< position of its first header byte
  std::size_t bytes = 0;  ///< length of its content
};

/// Checked contents of a LAS or LAZ file, without the points.
struct LasFile {
  std::filesystem::path path;
  /// All bytes before the points, as in a file without compression: the record of the compression
  /// is left out.
  std::string head;
  int minor = 0;   ///< minor part of version 1.minor
  int format = 0;  ///< point format
  std::size_t header_bytes = 0;
  std::size_t record_bytes = 0;
  std::uint64_t points = 0;
  std::uint64_t file_bytes = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::optional<std::size_t> time_at;  ///< position of the GPS time in a record
  bool adjusted_time = false;  ///< GPS time is "adjusted standard"; otherwise seconds of week
  std::size_t source_at = 0;
  std::vector<Vlr> vlrs;
  std::vector<ExtraDimension> extra;
  /// Record length covered by the standard part and the described extra bytes.
  std::size_t described_bytes = 0;
  StripCrs crs;
  std::optional<Eigen::Vector3d> boresight_rad;  ///< recorded by a writer of this program

  /// Returns whether the header says where the waveforms begin.
  bool has_waveform_field() const { return minor >= 3 && header_bytes >= las::kEvlrAt; }
  std::uint64_t points_begin = 0;  ///< position of the points in the file
  std::optional<laz::CompressedPoints> compressed;
  std::uint64_t tail_begin = 0;  ///< position of the waveforms and extended records
  /// Positions of the extended records with positions of points (COPC).
  std::vector<std::uint64_t> indexes_at;

  std::uint64_t points_end() const {
    return compressed ? compressed->end : points_begin + points * record_bytes;
  }
  /// Returns the extra attribute of this name; nullptr if the file has no such attribute.
  const ExtraDimension* Find(std::string_view name) const;
  /// Returns the content of a variable length record.
  std::string_view Content(const Vlr& vlr) const {
    return std::string_view(head).substr(vlr.at + las::kVlrHeaderBytes, vlr.bytes);
  }
};

/// Returns the number of returns of the same pulse after this one.
std::uint8_t ReturnNumber(const LasFile& las, const char* record);
std::uint8_t ReturnsAfter(const LasFile& las, const char* record);

/// Returns the class of a record, without its flags.
std::uint8_t PointClass(const LasFile& las, const char* record);

/// Returns the flags of a record, as StripCloud::flags has them.
std::uint8_t PointFlags(const LasFile& las, const char* record);

/// Reads and checks everything but the points. Throws InvalidInput as OpenStrip does.
LasFile ReadLasFile(const std::filesystem::path& file);

/// Returns the length of a value of this type; 0 if the type does not exist.
std::size_t ExtraTypeBytes(int type);

/// Parses the attributes that the record "extra bytes" describes, which follow `base_bytes` bytes
/// of the standard part. Throws InvalidInput at `where` if they do not fit into the record.
std::vector<ExtraDimension> ParseExtraBytes(std::string_view content, std::size_t base_bytes,
                                            std::size_t record_bytes, const FileLocation& where);

/// Formats the descriptor of an attribute. For an attribute of type 0, `options` is its length in
/// bytes.
std::string FormatDescriptor(int type, std::size_t options, const std::string& name,
                             const std::string& description);

/// Formats a variable length record.
std::string FormatVlr(std::string_view user, std::uint16_t id, std::string_view title,
                      std::string_view content);

/// Formats the variable length record that contains these descriptors.
std::string FormatExtraBytes(const std::string& descriptors);

/// Returns the value of an attribute that consists of a single number.
double BlockValue(const ExtraDimension& dimension, const char* record);

/// Parses GeoTIFF keys, the contents of the records 34735 and 34737. Throws InvalidInput at `where`
/// for a bad directory or units other than metres.
StripCrs ParseGeoTiff(std::string_view directory, std::string_view ascii,
                      const FileLocation& where);

/// Parses well-known text of the version of 2001 or 2019. Throws InvalidInput at `where` for units
/// other than metres.
StripCrs ParseWkt(std::string_view text, const FileLocation& where);

/// Returns whether GeoTIFF keys say that heights refer to a geoid. Throws as ParseGeoTiff does.
bool ParseVerticalKeys(std::string_view directory, std::string_view ascii,
                       const FileLocation& where);

}  // namespace dn::lidar_internal
