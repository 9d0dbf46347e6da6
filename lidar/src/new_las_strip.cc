#include <dn/geo/little_endian.h>

#include <cstring>
#include <utility>

#include "las_file.h"
#include "las_writer.h"

namespace dn::lidar_internal {
namespace {

constexpr std::size_t kHeaderBytes = 375, kFormat = 6, kFormatBytes = 30;
constexpr std::size_t kSourceAt = 20, kTimeAt = 22, kVectorAt = kFormatBytes;
constexpr std::size_t kBeamAt = kVectorAt + 3 * sizeof(double);
constexpr int kUnsignedShort = 3, kDouble = 10;
constexpr std::uint16_t kWktEncoding = 16;  // required by point format 6; time: seconds of week

/// Returns the byte with the number of a return and the number of returns of its pulse.
char ReturnByte(const StripCloud& points, std::size_t i) {
  const int number = points.return_number.empty() ? 1 : points.return_number[i];
  const int after = points.returns_after.empty() ? 0 : points.returns_after[i];
  return static_cast<char>(number | (number + after) << 4);
}

std::size_t RecordBytes(bool with_beam) {
  return kBeamAt + (with_beam ? sizeof(std::uint16_t) : 0);
}

std::string DescribeExtraBytes(bool with_beam) {
  std::string descriptors;
  for (const char* name : {"ux", "uy", "uz"}) {
    descriptors += FormatDescriptor(kDouble, 0, name, "laser vector in sensor frame, m");
  }
  if (with_beam) descriptors += FormatDescriptor(kUnsignedShort, 0, "beam", "laser beam, from 0");
  return FormatExtraBytes(descriptors);
}

std::string Header(const LasGrid& grid) {
  std::string head(kHeaderBytes, '\0');
  std::memcpy(head.data(), "LASF", 4);
  StoreLittleEndian(kWktEncoding, head.data() + las::kEncodingAt);
  head[las::kVersionAt] = 1;
  head[las::kVersionAt + 1] = 4;
  StoreLittleEndian(static_cast<std::uint16_t>(kHeaderBytes), head.data() + las::kHeaderBytesAt);
  StoreLittleEndian(std::uint32_t{1}, head.data() + las::kVlrCountAt);
  head[las::kFormatAt] = static_cast<char>(kFormat);
  for (std::size_t i = 0; i < 3; ++i) {
    StoreLittleEndian(grid.scale_m, head.data() + las::kScaleAt + 8 * i);
    StoreLittleEndian(grid.offset_m[static_cast<Eigen::Index>(i)],
                      head.data() + las::kOffsetAt + 8 * i);
  }
  return head;
}

/// Returns the description of a file without points; nothing is written to disk.
LasFile EmptyFile(const std::filesystem::path& path, const LasGrid& grid, bool with_beam) {
  LasFile las;
  las.path = path;
  las.head = Header(grid) + DescribeExtraBytes(with_beam);
  las.minor = 4;
  las.format = static_cast<int>(kFormat);
  las.header_bytes = kHeaderBytes;
  las.record_bytes = las.described_bytes = RecordBytes(with_beam);
  las.file_bytes = las.points_begin = las.tail_begin = las.head.size();
  las.scale.setConstant(grid.scale_m);
  las.offset = grid.offset_m;
  las.time_at = kTimeAt;
  las.source_at = kSourceAt;
  return las;
}

/// Builds the LAS records of points that do not come from a LAS file.
class NewLasWriter final : public StripWriter {
 public:
  NewLasWriter(const std::filesystem::path& file, const LasGrid& grid, bool with_beam)
      : writer_(file, EmptyFile(file, grid, with_beam), {}), with_beam_(with_beam) {
    points_.record_bytes = RecordBytes(with_beam);
  }

  void Append(const StripCloud& points) override {
    points_.p_c = points.p_c;
    const std::size_t bytes = points_.record_bytes;
    points_.records.assign(points.size() * bytes, '\0');
    for (std::size_t i = 0; i < points.size(); ++i) {
      StoreRecord(points, i, points_.records.data() + i * bytes);
      if (with_beam_) {
        StoreLittleEndian(points.beam[i], points_.records.data() + i * bytes + kBeamAt);
      }
    }
    writer_.Append(points_);
  }

  void Finish() override { writer_.Finish(); }

 private:
  static void StoreRecord(const StripCloud& points, std::size_t i, char* record) {
    if (!points.intensity.empty()) {
      StoreLittleEndian(points.intensity[i], record + las::kIntensityAt);
    }
    record[las::kReturnAt] = ReturnByte(points, i);
    if (!points.flags.empty()) record[las::kFlagsAt] = static_cast<char>(points.flags[i]);
    if (!points.classification.empty()) {
      record[las::kClassAt] = static_cast<char>(points.classification[i]);
    }
    if (!points.source.empty()) StoreLittleEndian(points.source[i], record + kSourceAt);
    StoreLittleEndian(points.t_s[i], record + kTimeAt);
    for (std::size_t k = 0; k < 3; ++k) {
      StoreLittleEndian(points.u_s[i][static_cast<Eigen::Index>(k)],
                        record + kVectorAt + k * sizeof(double));
    }
  }

  LasWriter writer_;
  bool with_beam_;
  StripCloud points_;
};

}  // namespace
}  // namespace dn::lidar_internal

namespace dn {

std::unique_ptr<StripWriter> NewLasStrip(const std::filesystem::path& file, const LasGrid& grid,
                                         bool with_beam) {
  return std::make_unique<lidar_internal::NewLasWriter>(file, grid, with_beam);
}

}  // namespace dn
