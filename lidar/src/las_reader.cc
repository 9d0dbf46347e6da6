#include "las_reader.h"

#include <dn/geo/little_endian.h>
#include <dn/geo/text_table.h>
#include <dn/geo/week_seconds.h>

#include <algorithm>
#include <cmath>

#include "beam_number.h"
#include "chunk_points.h"
#include "las_writer.h"
#include "laser_vector.h"

namespace dn::lidar_internal {
namespace {

// "Adjusted standard" GPS time counts seconds from this origin, which is in seconds since 1980.
constexpr double kAdjustedOriginS = 1e9;
// Largest accepted adjusted time; it corresponds to the year 2100.
constexpr double kMostAdjustedS = 2.8e9;
constexpr int kLastIntegerType = 8;  // of the types of extra bytes, from 1
constexpr std::uint64_t kChunkBytes = std::uint64_t{8} << 20;

std::string DescribePoint(std::uint64_t index) { return "point " + std::to_string(index + 1); }

}  // namespace

LasReader::LasReader(const std::filesystem::path& file)
    : las_(ReadLasFile(file)), in_(file, std::ios::binary) {
  if (!in_) throw InvalidInput("file cannot be opened for reading", Where());
  in_.seekg(static_cast<std::streamoff>(las_.points_begin));
  if (las_.compressed) compressed_.emplace(&in_, &*las_.compressed);
  const std::array<const ExtraDimension*, 3> vector{las_.Find("ux"), las_.Find("uy"),
                                                    las_.Find("uz")};
  const auto is_number = [](const ExtraDimension* each) {
    return each != nullptr && each->type >= 1 && each->type <= 10;
  };
  if (std::all_of(vector.begin(), vector.end(), is_number)) vector_ = vector;
  const ExtraDimension* beam = las_.Find("beam");
  if (beam != nullptr && beam->type >= 1 && beam->type <= kLastIntegerType) beam_ = beam;
}

bool LasReader::Next(StripCloud* chunk) {
  chunk->Clear();
  const std::uint64_t most =
      std::clamp<std::uint64_t>(kChunkBytes / las_.record_bytes, 1, kChunkPoints);
  const std::uint64_t count = std::min(most, las_.points - read_);
  ReadRecords(count, chunk);
  return count > 0;
}

void LasReader::ReadRecords(std::uint64_t count, StripCloud* chunk) {
  chunk->record_bytes = las_.record_bytes;
  chunk->records.resize(count * las_.record_bytes);
  if (compressed_) {
    ReadCompressed(count, &chunk->records);
  } else {
    ReadPlain(&chunk->records);
  }
  for (std::uint64_t i = 0; i < count; ++i, ++read_) {
    Decode(read_, chunk->records.data() + i * las_.record_bytes, chunk);
  }
}

void LasReader::ReadPlain(std::string* records) {
  in_.read(records->data(), static_cast<std::streamsize>(records->size()));
  if (static_cast<std::size_t>(in_.gcount()) != records->size()) {
    throw InvalidInput(
        "file ends at " + DescribePoint(read_) + " of " + std::to_string(las_.points), Where());
  }
}

void LasReader::ReadCompressed(std::uint64_t count, std::string* records) {
  try {
    compressed_->Read(count, las_.record_bytes, records->data());
  } catch (const laz::Damaged& e) {
    throw InvalidInput("LAZ: the points from " + DescribePoint(read_) + " to " +
                           std::to_string(read_ + count) + " cannot be decompressed: " + e.what() +
                           "; copy the file again, or compress it again",
                       Where());
  }
}

void LasReader::Decode(std::uint64_t index, const char* record, StripCloud* chunk) {
  Eigen::Vector3d p_c;
  for (int i = 0; i < 3; ++i) {
    p_c[i] = LoadLittleEndian<std::int32_t>(record + 4 * i) * las_.scale[i] + las_.offset[i];
  }
  chunk->p_c.push_back(p_c);
  chunk->intensity.push_back(LoadLittleEndian<std::uint16_t>(record + las::kIntensityAt));
  chunk->source.push_back(LoadLittleEndian<std::uint16_t>(record + las_.source_at));
  chunk->return_number.push_back(ReturnNumber(las_, record));
  chunk->returns_after.push_back(ReturnsAfter(las_, record));
  chunk->classification.push_back(PointClass(las_, record));
  chunk->flags.push_back(PointFlags(las_, record));
  if (las_.time_at) chunk->t_s.push_back(Time(index, record));
  if (beam_ != nullptr) chunk->beam.push_back(Beam(index, record));
  if (!has_vectors()) return;
  const Eigen::Vector3d u_s(BlockValue(*vector_[0], record), BlockValue(*vector_[1], record),
                            BlockValue(*vector_[2], record));
  try {
    CheckLaserVector(u_s, Where());
  } catch (const InvalidInput& e) {
    throw InvalidInput(DescribePoint(index) + ": " + e.what(), Where());
  }
  chunk->u_s.push_back(u_s);
}

std::uint16_t LasReader::Beam(std::uint64_t index, const char* record) const {
  try {
    return CheckedBeam(BlockValue(*beam_, record), Where());
  } catch (const InvalidInput& e) {
    throw InvalidInput(DescribePoint(index) + ": " + e.what() +
                           ", or rename the extra bytes `beam` if they mean something else",
                       Where());
  }
}

double LasReader::Time(std::uint64_t index, const char* record) {
  const auto tag_s = LoadLittleEndian<double>(record + *las_.time_at);
  if (!std::isfinite(tag_s)) {
    throw InvalidInput("GPS time of " + DescribePoint(index) + " is not a finite number", Where());
  }
  const auto error = [&](const std::string& why) {
    return InvalidInput("GPS time " + FormatDouble(tag_s) + " of " + DescribePoint(index) + why,
                        Where());
  };
  if (las_.adjusted_time && std::abs(tag_s) > kMostAdjustedS) {
    throw error(
        " is not valid as adjusted standard time, the type in the header (bit 0 of byte 6): GPS "
        "seconds since 1980 minus 1e9");
  }
  if (!time_origin_s_) {
    const double week = std::floor((tag_s + kAdjustedOriginS) / kWeekS);
    time_origin_s_ = las_.adjusted_time ? week * kWeekS - kAdjustedOriginS : 0.0;
  }
  const double t_s = tag_s - *time_origin_s_;
  if (IsWeekSeconds(t_s)) return t_s;
  if (las_.adjusted_time) {
    throw error(" lies outside the week of the first point, which begins at " +
                FormatDouble(*time_origin_s_) + " s; split the file by weeks");
  }
  throw error(
      " is not valid as seconds of week, the type in the header (bit 0 of byte 6); if it is "
      "adjusted standard time, set the bit");
}

std::unique_ptr<StripWriter> LasReader::MakeWriter(const std::filesystem::path& file,
                                                   const StripAdditions& additions) const {
  return std::make_unique<LasWriter>(file, las_, additions);
}

}  // namespace dn::lidar_internal
