#include "las_file.h"

#include <dn/geo/little_endian.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace dn::lidar_internal {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostLasBytes = std::uintmax_t{1} << 42;
constexpr std::uint64_t kMostHeadBytes = std::uint64_t{64} << 20;
constexpr std::uint64_t kMostWktBytes = std::uint64_t{1} << 20;
// This limit is far above the few records that programs write.
constexpr std::uint64_t kMostRecords = 10000;
constexpr double kMostScaleM = 1e3;
constexpr double kMostOffsetM = 1e9;
constexpr double kMaxAngleDeg = 180.0;

// Record lengths of point formats 0 to 10, in bytes.
constexpr std::array<std::size_t, 11> kFormatBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

std::string Bytes(std::uint64_t count) { return std::to_string(count) + " bytes"; }

/// Reads the header, its variable length records and the data after the points.
class LasFileReader {
 public:
  explicit LasFileReader(const fs::path& path) : where_{path.string()} { las_.path = path; }

  LasFile Read() {
    ExpectRegularFile(las_.path, kMostLasBytes);
    las_.file_bytes = fs::file_size(las_.path);
    in_.open(las_.path, std::ios::binary);
    if (!in_) throw InvalidInput("file cannot be opened for reading", where_);
    ReadHead();
    ReadLayout();
    ReadCounts();
    ReadGrid();
    ReadVlrs();
    ReadCompression();
    ExpectPoints();
    ReadTail();
    ReadCrs();
    return std::move(las_);
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw InvalidInput("LAS header: " + what, where_);
  }

  template <class T>
  T Number(std::size_t at) const {
    return LoadLittleEndian<T>(las_.head.data() + at);
  }

  std::string ReadBytes(std::uint64_t at, std::uint64_t count) {
    std::string bytes(count, '\0');
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(at));
    in_.read(bytes.data(), static_cast<std::streamsize>(count));
    if (static_cast<std::uint64_t>(in_.gcount()) != count) {
      throw InvalidInput("file cannot be read at byte " + std::to_string(at), where_);
    }
    return bytes;
  }

  // Some programs write version 1.3 with the shorter header of the versions before.
  std::size_t LeastHeaderBytes() const { return las_.minor < 4 ? 227 : 375; }

  void ReadHead() {
    constexpr std::uint64_t kThroughOffset = 105;
    if (las_.file_bytes < kThroughOffset) {
      throw InvalidInput(
          "file has " + Bytes(las_.file_bytes) + ", but a LAS header has at least 227", where_);
    }
    las_.head = ReadBytes(0, kThroughOffset);
    if (!las_.head.starts_with("LASF")) {
      throw InvalidInput("this is not a LAS file: it does not begin with LASF", where_);
    }
    const int major = Number<std::uint8_t>(las::kVersionAt);
    las_.minor = Number<std::uint8_t>(las::kVersionAt + 1);
    if (major != 1 || las_.minor > 4) {
      Fail("version " + std::to_string(major) + "." + std::to_string(las_.minor) +
           " (byte 24) is not supported; convert the file to LAS 1.4");
    }
    const auto points_begin = Number<std::uint32_t>(las::kPointsAt);
    las_.header_bytes = Number<std::uint16_t>(las::kHeaderBytesAt);
    if (las_.header_bytes < LeastHeaderBytes()) {
      Fail("the header size (byte 94) is " + std::to_string(las_.header_bytes) +
           ", but version 1." + std::to_string(las_.minor) + " needs at least " +
           std::to_string(LeastHeaderBytes()));
    }
    if (points_begin < las_.header_bytes || points_begin > las_.file_bytes) {
      Fail("the points begin (byte 96) at byte " + std::to_string(points_begin) +
           ", which must lie after the header of " + Bytes(las_.header_bytes) +
           " and within the file of " + Bytes(las_.file_bytes));
    }
    if (points_begin > kMostHeadBytes) {
      Fail("the points begin (byte 96) at byte " + std::to_string(points_begin) +
           ", but the limit is " + std::to_string(kMostHeadBytes) + "; remove unneeded records");
    }
    las_.head = ReadBytes(0, points_begin);
    las_.points_begin = points_begin;
  }

  void ReadLayout() {
    auto format = Number<std::uint8_t>(las::kFormatAt);
    says_compressed_ = (format & las::kCompressedBit) != 0;
    format &= static_cast<std::uint8_t>(~las::kCompressedBit);
    las_.head[las::kFormatAt] = static_cast<char>(format);
    const int most = las_.minor < 3 ? 3 : las_.minor == 3 ? 5 : 10;
    if (format > most) {
      Fail("point format " + std::to_string(format) + " (byte 104) is not supported: version 1." +
           std::to_string(las_.minor) + " allows 0 to " + std::to_string(most));
    }
    las_.format = format;
    las_.record_bytes = Number<std::uint16_t>(las::kRecordBytesAt);
    if (las_.record_bytes < kFormatBytes[format]) {
      Fail("a record has " + Bytes(las_.record_bytes) + " (byte 105), but point format " +
           std::to_string(format) + " needs at least " + std::to_string(kFormatBytes[format]));
    }
    const bool extended = format >= 6;
    las_.source_at = extended ? 20 : 18;
    if (extended) {
      las_.time_at = 22;
    } else if (format != 0 && format != 2) {
      las_.time_at = 20;
    }
    // These bytes have no meaning before version 1.2.
    las_.adjusted_time = las_.minor >= 2 && (Number<std::uint16_t>(las::kEncodingAt) & 1) != 0;
    las_.described_bytes = kFormatBytes[format];
  }

  void ReadCounts() {
    const auto legacy = Number<std::uint32_t>(las::kLegacyCountAt);
    las_.points = las_.minor < 4 ? legacy : Number<std::uint64_t>(las::kCountAt);
    if (las_.minor == 4 && legacy != 0 && legacy != las_.points) {
      Fail("it gives two different numbers of points, " + std::to_string(las_.points) +
           " (byte 247) and " + std::to_string(legacy) + " (byte 107); repair it");
    }
  }

  /// Checks that a file without compression has room for its points.
  void ExpectPoints() const {
    if (las_.compressed) return;
    const std::uint64_t room = las_.file_bytes - las_.points_begin;
    if (las_.points > room / las_.record_bytes) {
      Fail("it announces " + std::to_string(las_.points) + " points of " +
           Bytes(las_.record_bytes) + " from byte " + std::to_string(las_.points_begin) +
           " on, but the file ends after " + std::to_string(room / las_.record_bytes) +
           " of them (" + Bytes(las_.file_bytes) +
           "): it is truncated, or the header is wrong; copy it again, or repair it");
    }
  }

  /// Reads a number of the header; throws InvalidInput unless it is finite.
  double Real(const char* what, std::size_t at) const {
    const auto value = Number<double>(at);
    if (!std::isfinite(value)) {
      Fail(std::string(what) + " (byte " + std::to_string(at) + ") is not a finite number");
    }
    return value;
  }

  void ReadGrid() {
    for (int i = 0; i < 3; ++i) {
      const std::size_t scale_at = las::kScaleAt + static_cast<std::size_t>(8 * i);
      const std::size_t offset_at = las::kOffsetAt + static_cast<std::size_t>(8 * i);
      las_.scale[i] = Real("scale factor", scale_at);
      las_.offset[i] = Real("offset", offset_at);
      if (!(las_.scale[i] > 0.0 && las_.scale[i] <= kMostScaleM)) {
        Fail("scale factor " + FormatDouble(las_.scale[i]) + " (byte " + std::to_string(scale_at) +
             ") must be positive and at most 1000 m");
      }
      if (std::abs(las_.offset[i]) > kMostOffsetM) {
        Fail("offset " + FormatDouble(las_.offset[i]) + " (byte " + std::to_string(offset_at) +
             ") must lie between -1e9 and 1e9 m");
      }
    }
  }

  static std::string TextUpToNull(std::string_view bytes) {
    return std::string(bytes.substr(0, bytes.find('\0')));
  }

  /// Throws if the records, each with a header, do not fit into `room` bytes, or if they are too
  /// many.
  void ExpectRoomForRecords(const char* what, std::size_t count_at, std::uint64_t count,
                            std::uint64_t room, std::size_t header) const {
    const std::string promised = std::to_string(count) + " " + what + " (byte " +
                                 std::to_string(count_at) + ") are promised";
    if (count > room / header) {
      Fail(promised + ", but there are " + Bytes(room) + " for them, and each has at least " +
           std::to_string(header) + "; repair it");
    }
    if (count > kMostRecords) {
      Fail(promised + ", at most " + std::to_string(kMostRecords) +
           " are read; remove unneeded records");
    }
  }

  void ReadVlrs() {
    const auto count = Number<std::uint32_t>(las::kVlrCountAt);
    ExpectRoomForRecords("variable length records", las::kVlrCountAt, count,
                         las_.head.size() - las_.header_bytes, las::kVlrHeaderBytes);
    std::size_t at = las_.header_bytes;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::size_t room = las_.head.size() - at;
      const std::string name = "variable length record " + std::to_string(i + 1) + " of " +
                               std::to_string(count) + " (byte 100), at byte " + std::to_string(at);
      if (room < las::kVlrHeaderBytes) Fail(name + ", extends into the points");
      Vlr vlr{TextUpToNull(std::string_view(las_.head).substr(at + 2, 16)),
              Number<std::uint16_t>(at + 18), at, Number<std::uint16_t>(at + 20)};
      if (room - las::kVlrHeaderBytes < vlr.bytes) {
        Fail(name + ", has " + Bytes(vlr.bytes) +
             " of content and therefore extends into the points");
      }
      at += las::kVlrHeaderBytes + vlr.bytes;
      if (vlr.user == "LASF_Spec" && vlr.id == las::kExtraBytesId) ReadExtraBytes(vlr);
      if (vlr.user == las::kBoresightUser && vlr.id == las::kBoresightId) ReadBoresight(vlr);
      las_.vlrs.push_back(std::move(vlr));
    }
  }

  /// Reads the record of the compression and removes it from the head.
  void ReadCompression() {
    const auto vlr = std::find_if(las_.vlrs.begin(), las_.vlrs.end(), [](const Vlr& each) {
      return each.user == laz::Compression::kUser && each.id == laz::Compression::kId;
    });
    if (vlr == las_.vlrs.end()) {
      if (says_compressed_)
        Fail("the points are compressed, but the record that says how is missing");
      return;
    }
    try {
      const laz::Compression compression =
          laz::ParseCompression(las_.Content(*vlr), las_.format, las_.record_bytes);
      las_.compressed =
          laz::FindChunks(&in_, compression, las_.points_begin, las_.file_bytes, las_.points);
    } catch (const laz::Damaged& e) {
      throw InvalidInput(std::string("LAZ: ") + e.what() + "; copy the file again, or repair it",
                         where_);
    }
    RemoveVlr(vlr);
  }

  void RemoveVlr(std::vector<Vlr>::iterator vlr) {
    const std::size_t bytes = las::kVlrHeaderBytes + vlr->bytes;
    las_.head.erase(vlr->at, bytes);
    const auto count = Number<std::uint32_t>(las::kVlrCountAt);
    StoreLittleEndian(count - 1, las_.head.data() + las::kVlrCountAt);
    vlr = las_.vlrs.erase(vlr);
    for (; vlr != las_.vlrs.end(); ++vlr) vlr->at -= bytes;
  }

  void ReadExtraBytes(const Vlr& vlr) {
    las_.extra =
        ParseExtraBytes(las_.Content(vlr), kFormatBytes[static_cast<std::size_t>(las_.format)],
                        las_.record_bytes, where_);
    if (!las_.extra.empty()) las_.described_bytes = las_.extra.back().at + las_.extra.back().bytes;
  }

  void ReadBoresight(const Vlr& vlr) {
    const std::string remedy = "; georeference the file again, or remove the record";
    if (vlr.bytes != las::kBoresightBytes) {
      Fail("the record of the boresight (dn, 1) has " + Bytes(vlr.bytes) + " of content, not " +
           Bytes(las::kBoresightBytes) + remedy);
    }
    Eigen::Vector3d deg;
    for (int i = 0; i < 3; ++i) {
      deg[i] = Number<double>(vlr.at + las::kVlrHeaderBytes + static_cast<std::size_t>(8 * i));
    }
    if (!(deg.cwiseAbs().maxCoeff() <= kMaxAngleDeg) || !deg.allFinite()) {
      Fail("the record of the boresight (dn, 1) has an angle beyond 180 deg" + remedy);
    }
    las_.boresight_rad = deg * kRadPerDeg;
  }

  // Reads the data after the points, or checks that the file ends there.
  void ReadTail() {
    const std::uint64_t tail = las_.points_end();
    las_.tail_begin = las_.compressed ? las_.file_bytes : tail;
    if (las_.minor == 4 && Number<std::uint32_t>(las::kEvlrCountAt) > 0) {
      ReadEvlrs();
      return;
    }
    if (las_.has_waveform_field()) {
      const auto waveform = Number<std::uint64_t>(las::kWaveformAt);
      if (waveform != 0 && (waveform < tail || waveform > las_.file_bytes)) {
        Fail("the waveforms begin (byte 227) at byte " + std::to_string(waveform) +
             ", which must lie after the points, which end at byte " + std::to_string(tail) +
             ", and within the file of " + Bytes(las_.file_bytes));
      }
      if (waveform != 0) return BeginTail(waveform);
    }
    if (las_.compressed) return;
    if (las_.file_bytes - tail >= las_.record_bytes) {
      Fail(Bytes(las_.file_bytes - tail) + " follow the " + std::to_string(las_.points) +
           " points that it announces: the number of points is wrong; repair it");
    }
  }

  /// Notes where data after compressed points begin. Other files are copied from the last point on.
  void BeginTail(std::uint64_t begin) {
    if (las_.compressed) las_.tail_begin = std::min(las_.tail_begin, begin);
  }

  void ReadEvlrs() {
    const auto count = Number<std::uint32_t>(las::kEvlrCountAt);
    const auto begin = Number<std::uint64_t>(las::kEvlrAt);
    if (begin < las_.points_end()) {
      Fail("the extended records begin (byte 235) at byte " + std::to_string(begin) +
           ", before the end of the points at byte " + std::to_string(las_.points_end()));
    }
    if (begin > las_.file_bytes) {
      Fail("the extended records begin (byte 235) at byte " + std::to_string(begin) +
           ", beyond the end of the file of " + Bytes(las_.file_bytes));
    }
    ExpectRoomForRecords("extended records", las::kEvlrCountAt, count, las_.file_bytes - begin,
                         las::kEvlrHeaderBytes);
    std::uint64_t at = begin;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::string name = "extended record " + std::to_string(i + 1) + " of " +
                               std::to_string(count) + " (byte 243), at byte " + std::to_string(at);
      if (at > las_.file_bytes || las_.file_bytes - at < las::kEvlrHeaderBytes) {
        Fail(name + ", lies beyond the end of the file");
      }
      const std::string header = ReadBytes(at, las::kEvlrHeaderBytes);
      const auto bytes = LoadLittleEndian<std::uint64_t>(header.data() + 20);
      if (bytes > las_.file_bytes - at - las::kEvlrHeaderBytes) {
        Fail(name + ", has " + Bytes(bytes) + " of content, beyond the end of the file");
      }
      const auto id = LoadLittleEndian<std::uint16_t>(header.data() + 18);
      if (TextUpToNull(header.substr(2, 16)) == "LASF_Projection" && id == kWktId &&
          bytes <= kMostWktBytes) {
        extended_wkt_ = ReadBytes(at + las::kEvlrHeaderBytes, bytes);
      }
      if (TextUpToNull(header.substr(2, 16)) == las::kIndexUser) las_.indexes_at.push_back(at);
      at += las::kEvlrHeaderBytes + bytes;
    }
    if (!las_.compressed) ExpectLittleElse(begin - las_.points_end() + las_.file_bytes - at);
    BeginTail(begin);
    if (const auto waveform = Number<std::uint64_t>(las::kWaveformAt);
        waveform >= las_.points_end()) {
      BeginTail(waveform);
    }
  }

  /// Throws if too many bytes after the points belong to no record. They are copied when the file
  /// is rewritten, so their size is limited.
  void ExpectLittleElse(std::uint64_t bytes) const {
    if (bytes <= kMostHeadBytes || Number<std::uint64_t>(las::kWaveformAt) != 0) return;
    Fail(Bytes(bytes) + " after the points belong to no record listed in the header; repair it");
  }

  // Well-known text takes precedence over GeoTIFF keys: if a file has both, the keys are the older
  // copy.
  void ReadCrs() {
    std::string_view directory, ascii, wkt = extended_wkt_;
    for (const Vlr& vlr : las_.vlrs) {
      if (vlr.user != "LASF_Projection") continue;
      if (vlr.id == kGeoKeysId) directory = las_.Content(vlr);
      if (vlr.id == kGeoAsciiId) ascii = las_.Content(vlr);
      if (vlr.id == kWktId) wkt = las_.Content(vlr);
    }
    if (!wkt.empty()) {
      las_.crs = ParseWkt(wkt.substr(0, wkt.find('\0')), where_);
      // Text of a horizontal system alone leaves the heights to the keys.
      const bool has_vertical =
          las_.crs.heights_from_geoid || las_.crs.name.find('+') != std::string::npos;
      if (!has_vertical && !directory.empty()) {
        las_.crs.heights_from_geoid = ParseVerticalKeys(directory, ascii, where_);
      }
    } else if (!directory.empty()) {
      las_.crs = ParseGeoTiff(directory, ascii, where_);
    }
  }

  static constexpr std::uint16_t kGeoKeysId = 34735, kGeoAsciiId = 34737, kWktId = 2112;

  FileLocation where_;
  std::ifstream in_;
  LasFile las_;
  std::string extended_wkt_;
  bool says_compressed_ = false;
};

/// Returns the number of bits that hold the number of a return.
int ReturnBits(const LasFile& las) { return las.format >= 6 ? 4 : 3; }

}  // namespace

const ExtraDimension* LasFile::Find(std::string_view name) const {
  const auto at = std::find_if(extra.begin(), extra.end(),
                               [&](const ExtraDimension& each) { return each.name == name; });
  return at == extra.end() ? nullptr : &*at;
}

std::uint8_t ReturnNumber(const LasFile& las, const char* record) {
  const int mask = (1 << ReturnBits(las)) - 1;
  return static_cast<std::uint8_t>(record[las::kReturnAt] & mask);
}

std::uint8_t ReturnsAfter(const LasFile& las, const char* record) {
  const auto byte = static_cast<std::uint8_t>(record[las::kReturnAt]);
  const int mask = (1 << ReturnBits(las)) - 1;
  const int of = (byte >> ReturnBits(las)) & mask;
  return static_cast<std::uint8_t>(std::max(0, of - ReturnNumber(las, record)));
}

std::uint8_t PointClass(const LasFile& las, const char* record) {
  constexpr std::uint8_t kWithoutFlags = 0x1f;
  if (las.format >= 6) return static_cast<std::uint8_t>(record[las::kClassAt]);
  return static_cast<std::uint8_t>(record[las::kLegacyClassAt]) & kWithoutFlags;
}

std::uint8_t PointFlags(const LasFile& las, const char* record) {
  const auto byte = static_cast<std::uint8_t>(record[las::kLegacyClassAt]);
  return static_cast<std::uint8_t>(las.format >= 6 ? byte & 15 : byte >> 5);
}

LasFile ReadLasFile(const fs::path& file) { return LasFileReader(file).Read(); }

}  // namespace dn::lidar_internal
