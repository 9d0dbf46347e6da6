#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "laz/laz.h"
#include "testing/laz_records.h"

namespace dn::lidar_test {

using lidar_internal::laz::ByteSource;
using lidar_internal::laz::CompressedPoints;
using lidar_internal::laz::Compression;
using lidar_internal::laz::Compressor;
using lidar_internal::laz::Damaged;
using lidar_internal::laz::Item;
using lidar_internal::laz::ItemType;
using testing::LazRecords;

constexpr std::uint64_t kBegin = 8;  // position of the compressed points in the made-up files

struct Compressed {
  Compression compression;
  std::string file;
};

Compressed Compress(const Compression& compression, const std::string& records) {
  lidar_internal::laz::PointWriter writer(compression, kBegin);
  writer.Append(records);
  writer.Finish();
  std::string points = writer.TakeBytes();
  for (int i = 0; i < 8; ++i) {
    points[static_cast<std::size_t>(i)] = static_cast<char>(writer.table_at() >> (8 * i) & 0xFF);
  }
  return {compression, std::string(kBegin, '-') + points};
}

std::string Decompress(const Compressed& compressed, std::size_t points, std::size_t record_bytes,
                       std::size_t at_once = 1000) {
  std::istringstream in(compressed.file);
  const CompressedPoints found = lidar_internal::laz::FindChunks(
      &in, compressed.compression, kBegin, compressed.file.size(), points);
  lidar_internal::laz::PointReader reader(&in, &found);
  std::string records(points * record_bytes, '\0');
  for (std::size_t read = 0; read < points; read += at_once) {
    const std::size_t part = std::min(at_once, points - read);
    reader.Read(part, record_bytes, records.data() + read * record_bytes);
  }
  return records;
}

class EveryPointFormat : public ::testing::TestWithParam<int> {};

TEST_P(EveryPointFormat, SurvivesCompressionInChunks) {
  constexpr std::size_t kPoints = 4321;
  const LazRecords records(GetParam(), 5, kPoints, 1);
  Compression compression =
      lidar_internal::laz::MakeCompression(GetParam(), records.record_bytes());
  compression.chunk_points = 1000;
  const Compressed compressed = Compress(compression, records.bytes());
  EXPECT_LT(compressed.file.size(), records.bytes().size());
  EXPECT_EQ(Decompress(compressed, kPoints, records.record_bytes(), 700), records.bytes());
}

TEST_P(EveryPointFormat, SurvivesCompressionInEachVersionOfItsItems) {
  constexpr std::size_t kPoints = 2000;
  const LazRecords records(GetParam(), 3, kPoints, 2);
  Compression compression =
      lidar_internal::laz::MakeCompression(GetParam(), records.record_bytes());
  const bool layered = compression.compressor == Compressor::kLayered;
  for (int version = layered ? 3 : 1; version <= (layered ? 4 : 2); ++version) {
    SCOPED_TRACE(version);
    for (Item& item : compression.items) item.version = static_cast<std::uint16_t>(version);
    EXPECT_EQ(Decompress(Compress(compression, records.bytes()), kPoints, records.record_bytes()),
              records.bytes());
  }
}

TEST_P(EveryPointFormat, SurvivesPointsWithoutAnyRegularity) {
  constexpr std::size_t kPoints = 500;
  std::mt19937 random(3);
  const std::size_t record_bytes = LazRecords(GetParam(), 2, 0, 0).record_bytes();
  std::string records(kPoints * record_bytes, '\0');
  for (char& byte : records) byte = static_cast<char>(random());
  const Compression compression = lidar_internal::laz::MakeCompression(GetParam(), record_bytes);
  EXPECT_EQ(Decompress(Compress(compression, records), kPoints, record_bytes), records);
}

TEST_P(EveryPointFormat, SurvivesOnePointAndEqualPoints) {
  const LazRecords one(GetParam(), 4, 1, 4);
  const Compression compression =
      lidar_internal::laz::MakeCompression(GetParam(), one.record_bytes());
  EXPECT_EQ(Decompress(Compress(compression, one.bytes()), 1, one.record_bytes()), one.bytes());
  std::string equal;
  for (int i = 0; i < 3000; ++i) equal += one.bytes();
  const Compressed compressed = Compress(compression, equal);
  EXPECT_LT(20 * compressed.file.size(), equal.size());
  EXPECT_EQ(Decompress(compressed, 3000, one.record_bytes()), equal);
}

TEST_P(EveryPointFormat, EveryChangedBitIsDecodedOrRejected) {
  constexpr std::size_t kPoints = 25;
  const LazRecords records(GetParam(), 2, kPoints, 8);
  Compression compression =
      lidar_internal::laz::MakeCompression(GetParam(), records.record_bytes());
  compression.chunk_points = 10;
  Compressed compressed = Compress(compression, records.bytes());
  for (std::size_t bit = 8 * kBegin; bit < 8 * compressed.file.size(); ++bit) {
    char& byte = compressed.file[bit / 8];
    const char before = byte;
    byte = static_cast<char>(byte ^ 1 << bit % 8);
    try {
      Decompress(compressed, kPoints, records.record_bytes());
    } catch (const Damaged& e) {
      EXPECT_STRNE(e.what(), "");
    }
    byte = before;
  }
}

INSTANTIATE_TEST_SUITE_P(Laz, EveryPointFormat, ::testing::Range(0, 11));

/// Returns the FNV-1a checksum of bytes.
std::uint64_t Checksum(const std::string& bytes) {
  std::uint64_t sum = 0xcbf29ce484222325u;
  for (const char byte : bytes) {
    sum = (sum ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3u;
  }
  return sum;
}

// Checksums of compressed points that another implementation (laz-perf) decompresses correctly. It
// lacks the formats with waveforms.
TEST(LazCodec, CompressedBytesAreThoseThatOtherProgramsRead) {
  const std::map<int, std::uint64_t> checksums{{0, 0xcf895cfa083f7a89u}, {1, 0x4a2cba1fd40d3971u},
                                               {2, 0xe6a39f2fe17f2058u}, {3, 0x80b8009e36aadac1u},
                                               {6, 0xf2b762402723a675u}, {7, 0x2c0f033b5b27fa75u},
                                               {8, 0x58a9c7fc0900169fu}};
  for (const auto& [format, checksum] : checksums) {
    const LazRecords records(format, 5, 3000, 1);
    const Compressed compressed = Compress(
        lidar_internal::laz::MakeCompression(format, records.record_bytes()), records.bytes());
    EXPECT_EQ(Checksum(compressed.file.substr(kBegin + 8)), checksum) << format;
  }
}

TEST(LazCodec, ReadsPointsWithoutChunks) {
  constexpr std::size_t kPoints = 3000;
  const LazRecords records(3, 0, kPoints, 5);
  Compression compression = lidar_internal::laz::MakeCompression(3, records.record_bytes());
  Compressed compressed = Compress(compression, records.bytes());
  // A single chunk without the position of its table and the table is a file without chunks.
  compressed.file.erase(kBegin, 8);
  compressed.compression.compressor = Compressor::kPointwise;
  EXPECT_EQ(Decompress(compressed, kPoints, records.record_bytes()), records.bytes());
}

TEST(LazCodec, FindsTheTableThroughTheEndOfTheFile) {
  const LazRecords records(6, 0, 100, 6);
  Compressed compressed =
      Compress(lidar_internal::laz::MakeCompression(6, records.record_bytes()), records.bytes());
  compressed.file += compressed.file.substr(kBegin, 8);
  compressed.file.replace(kBegin, 8, 8, '\xFF');
  EXPECT_EQ(Decompress(compressed, 100, records.record_bytes()), records.bytes());
}

TEST(LazCodec, TheRecordOfTheCompressionReadsBack) {
  for (int format = 0; format <= 10; ++format) {
    const LazRecords records(format, format % 3, 0, 0);
    const Compression made = lidar_internal::laz::MakeCompression(format, records.record_bytes());
    const Compression read = lidar_internal::laz::ParseCompression(
        lidar_internal::laz::FormatCompression(made), format, records.record_bytes());
    EXPECT_EQ(read.compressor, made.compressor);
    EXPECT_EQ(read.chunk_points, made.chunk_points);
    ASSERT_EQ(read.items.size(), made.items.size());
    for (std::size_t i = 0; i < read.items.size(); ++i) {
      EXPECT_EQ(read.items[i].type, made.items[i].type);
      EXPECT_EQ(read.items[i].version, made.items[i].version);
    }
  }
}

TEST(LazCodec, RejectsCompressionsThatDoNotFitThePoints) {
  const std::string content =
      lidar_internal::laz::FormatCompression(lidar_internal::laz::MakeCompression(1, 30));
  const auto parse = [](const std::string& bytes, int format, std::size_t record_bytes) {
    lidar_internal::laz::ParseCompression(bytes, format, record_bytes);
  };
  EXPECT_NO_THROW(parse(content, 1, 30));
  EXPECT_THROW(parse(content.substr(0, 33), 1, 30), Damaged);
  EXPECT_THROW(parse(content.substr(0, 40), 1, 30), Damaged);
  EXPECT_THROW(parse(content, 1, 28), Damaged);
  EXPECT_THROW(parse(content, 0, 30), Damaged);
  EXPECT_THROW(parse(content, 6, 30), Damaged);
  for (const std::size_t at : {0u, 2u, 34u, 36u, 38u}) {
    std::string other = content;
    other[at] = 9;
    EXPECT_THROW(parse(other, 1, 30), Damaged) << at;
  }
}

TEST(LazCodec, MorePointsThanTheBytesCanHoldAreRejected) {
  const LazRecords records(6, 0, 10, 7);
  const Compressed compressed =
      Compress(lidar_internal::laz::MakeCompression(6, records.record_bytes()), records.bytes());
  std::istringstream in(compressed.file);
  for (const std::uint64_t points :
       {std::uint64_t{9}, std::uint64_t{50001}, std::uint64_t{1} << 62}) {
    EXPECT_THROW(
        {
          const auto found = lidar_internal::laz::FindChunks(&in, compressed.compression, kBegin,
                                                             compressed.file.size(), points);
          lidar_internal::laz::PointReader reader(&in, &found);
          std::string record(9 * records.record_bytes(), '\0');
          reader.Read(9, records.record_bytes(), record.data());
        },
        Damaged)
        << points;
  }
}

}  // namespace dn::lidar_test
