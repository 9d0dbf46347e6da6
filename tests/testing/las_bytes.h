#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace dn::testing {

/// A point as stored in a LAS file.
struct LasPoint {
  std::int32_t x = 0, y = 0, z = 0;  ///< in steps of the scale factor
  double time_s = 0.0;
  std::uint16_t intensity = 0;
  std::uint16_t source = 0;
  int return_number = 1;
  std::string extra;  ///< bytes after the standard part
  int returns = 0;    ///< number of returns of the pulse; 0: not stated
  int classification = 0;
};

/// A variable length record.
struct LasRecord {
  std::string user;
  std::uint16_t id = 0;
  std::string content;
};

/// Builds the bytes of a LAS file from the specification, without the library under test. Requires
/// a little-endian machine.
struct LasBytes {
  int minor = 2;
  int format = 1;
  std::uint16_t encoding = 0;
  double scale = 0.001;
  double offset[3] = {0.0, 0.0, 0.0};
  std::size_t extra_bytes = 0;  ///< per point record
  std::vector<LasRecord> vlrs;
  std::vector<LasRecord> evlrs;
  std::vector<LasPoint> points;

  static std::size_t FormatBytes(int format) {
    constexpr std::size_t kBytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    return kBytes[format];
  }
  std::size_t HeaderBytes() const { return minor < 3 ? 227 : minor == 3 ? 235 : 375; }
  std::size_t RecordBytes() const { return FormatBytes(format) + extra_bytes; }

  std::string Build() const {
    std::string bytes(HeaderBytes(), '\0');
    for (const LasRecord& vlr : vlrs) bytes += RecordHeader(vlr, 54) + vlr.content;
    const std::size_t points_begin = bytes.size();
    for (const LasPoint& point : points) bytes += Record(point);
    const std::size_t points_end = bytes.size();
    for (const LasRecord& evlr : evlrs) bytes += RecordHeader(evlr, 60) + evlr.content;
    FillHeader(points_begin, points_end, &bytes);
    return bytes;
  }

  /// Overwrites bytes of a file with those of a number.
  template <class T>
  static void Put(T value, std::size_t at, std::string* bytes) {
    std::memcpy(bytes->data() + at, &value, sizeof(T));
  }

 private:
  static std::string RecordHeader(const LasRecord& record, std::size_t size) {
    std::string header(size, '\0');
    record.user.copy(header.data() + 2, 16);
    Put(record.id, 18, &header);
    if (size == 60) {
      Put(static_cast<std::uint64_t>(record.content.size()), 20, &header);
    } else {
      Put(static_cast<std::uint16_t>(record.content.size()), 20, &header);
    }
    return header;
  }

  std::string Record(const LasPoint& point) const {
    std::string record(FormatBytes(format), '\0');
    Put(point.x, 0, &record);
    Put(point.y, 4, &record);
    Put(point.z, 8, &record);
    Put(point.intensity, 12, &record);
    record[14] = static_cast<char>(point.return_number | point.returns << (format >= 6 ? 4 : 3));
    record[format >= 6 ? 16 : 15] = static_cast<char>(point.classification);
    Put(point.source, format >= 6 ? 20 : 18, &record);
    if (format != 0 && format != 2) Put(point.time_s, format >= 6 ? 22 : 20, &record);
    std::string extra = point.extra;
    extra.resize(extra_bytes);
    return record + extra;
  }

  void FillHeader(std::size_t points_begin, std::size_t points_end, std::string* bytes) const {
    bytes->replace(0, 4, "LASF");
    Put(encoding, 6, bytes);
    (*bytes)[24] = 1;
    (*bytes)[25] = static_cast<char>(minor);
    bytes->replace(58, 2, "dn");
    Put(static_cast<std::uint16_t>(HeaderBytes()), 94, bytes);
    Put(static_cast<std::uint32_t>(points_begin), 96, bytes);
    Put(static_cast<std::uint32_t>(vlrs.size()), 100, bytes);
    (*bytes)[104] = static_cast<char>(format);
    Put(static_cast<std::uint16_t>(RecordBytes()), 105, bytes);
    std::uint64_t returns[15] = {};
    for (const LasPoint& point : points) ++returns[point.return_number - 1];
    const bool legacy = format < 6;
    Put(static_cast<std::uint32_t>(legacy ? points.size() : 0), 107, bytes);
    for (std::size_t k = 0; k < 5; ++k) {
      Put(static_cast<std::uint32_t>(legacy ? returns[k] : 0), 111 + 4 * k, bytes);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      Put(scale, 131 + 8 * i, bytes);
      Put(offset[i], 155 + 8 * i, bytes);
      PutBounds(i, bytes);
    }
    if (minor < 4) return;
    Put(static_cast<std::uint64_t>(evlrs.empty() ? 0 : points_end), 235, bytes);
    Put(static_cast<std::uint32_t>(evlrs.size()), 243, bytes);
    Put(static_cast<std::uint64_t>(points.size()), 247, bytes);
    for (std::size_t k = 0; k < 15; ++k) Put(returns[k], 255 + 8 * k, bytes);
  }

  void PutBounds(std::size_t axis, std::string* bytes) const {
    double least = 1e300, most = -1e300;
    for (const LasPoint& point : points) {
      const double steps = axis == 0 ? point.x : axis == 1 ? point.y : point.z;
      const double value = steps * scale + offset[axis];
      least = value < least ? value : least;
      most = value > most ? value : most;
    }
    Put(points.empty() ? 0.0 : most, 179 + 16 * axis, bytes);
    Put(points.empty() ? 0.0 : least, 187 + 16 * axis, bytes);
  }
};

/// Returns the record that describes extra bytes: a descriptor of 192 bytes per name, of type float
/// (9) or double (10).
inline LasRecord ExtraBytesRecord(const std::vector<std::string>& names, int type) {
  LasRecord record{"LASF_Spec", 4, ""};
  for (const std::string& name : names) {
    std::string descriptor(192, '\0');
    descriptor[2] = static_cast<char>(type);
    name.copy(descriptor.data() + 4, 32);
    record.content += descriptor;
  }
  return record;
}

}  // namespace dn::testing
