#include <dn/geo/read_file.h>
#include <dn/lidar/strip_io.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>

#include "testing/expect_invalid.h"
#include "testing/las_bytes.h"
#include "testing/temp_file.h"
#include "testing/temp_folder.h"

namespace dn::lidar_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::ExpectInvalidIn;
using testing::ExtraBytesRecord;
using testing::LasBytes;
using testing::LasPoint;
using testing::LasRecord;
using testing::TempFile;
namespace fs = std::filesystem;

LasBytes ThreePoints() {
  LasBytes las;
  las.offset[0] = 400000.0;
  las.offset[1] = 5e6;
  las.points = {{1000, -2000, 3000, 381000.125, 7, 41, 1, ""},
                {1001, -2001, 3001, 381000.250, 8, 41, 2, ""},
                {1002, -2002, 3002, 381000.375, 9, 42, 5, ""}};
  return las;
}

StripCloud ReadAll(const fs::path& file) {
  const auto reader = OpenStrip(file);
  StripCloud points;
  EXPECT_TRUE(reader->Next(&points));
  StripCloud more;
  EXPECT_FALSE(reader->Next(&more));
  return points;
}

/// Copies the points of a file to another file; returns the bytes of the copy.
std::string WrittenAgain(const TempFile& file, bool with_covariance = false,
                         const std::vector<bool>& drop = {},
                         const std::optional<Vector3d>& boresight_rad = {}) {
  const fs::path copy = file.path().parent_path() / "copy.las";
  const auto reader = OpenStrip(file.path());
  const auto writer =
      reader->MakeWriter(copy, {.covariance = with_covariance, .boresight_rad = boresight_rad});
  for (StripCloud points; reader->Next(&points);) {
    if (!drop.empty()) points.Drop(drop);
    if (with_covariance) {
      points.covariance_c_m2.assign(points.size(), Vector3d(1.0, 4.0, 9.0).asDiagonal());
      for (Matrix3d& C : points.covariance_c_m2) C(0, 1) = C(1, 0) = 0.5;
    }
    writer->Append(points);
  }
  writer->Finish();
  return ReadWholeFile(copy);
}

struct VersionAndFormat {
  int minor, format;
};

class EveryLasFormat : public ::testing::TestWithParam<VersionAndFormat> {};

TEST_P(EveryLasFormat, IsReadAndWrittenAgainByteByByte) {
  LasBytes las = ThreePoints();
  las.minor = GetParam().minor;
  las.format = GetParam().format;
  las.vlrs = {{"somebody", 7, "what nobody knows"}};
  const TempFile file("strip.las", las.Build());
  const StripCloud points = ReadAll(file.path());
  ASSERT_EQ(points.size(), 3u);
  EXPECT_LT((points.p_c[1] - Vector3d(400001.001, 4999997.999, 3.001)).norm(), 1e-9);
  EXPECT_EQ(points.intensity, (std::vector<std::uint16_t>{7, 8, 9}));
  EXPECT_EQ(points.source, (std::vector<std::uint16_t>{41, 41, 42}));
  if (las.format == 0 || las.format == 2) {
    EXPECT_TRUE(points.t_s.empty());
  } else {
    EXPECT_EQ(points.t_s, (std::vector<double>{381000.125, 381000.250, 381000.375}));
  }
  EXPECT_EQ(WrittenAgain(file), las.Build());
}

TEST_P(EveryLasFormat, CountsTheReturnsThatFollow) {
  LasBytes las = ThreePoints();
  las.minor = GetParam().minor;
  las.format = GetParam().format;
  las.points[0].returns = 5;  // these are return 1 of 5, return 2 of 3 and return 5 of 5
  las.points[1].returns = 3;
  las.points[2].returns = 5;
  const TempFile file("strip.las", las.Build());
  EXPECT_EQ(ReadAll(file.path()).returns_after, (std::vector<std::uint8_t>{4, 1, 0}));
  EXPECT_EQ(ReadAll(file.path()).return_number, (std::vector<std::uint8_t>{1, 2, 5}));
}

TEST_P(EveryLasFormat, ReadsClassesWithoutTheirFlags) {
  LasBytes las = ThreePoints();
  las.minor = GetParam().minor;
  las.format = GetParam().format;
  las.points[0].classification = 2;
  // In the old formats, the class is stored together with the flag "withheld".
  las.points[1].classification = las.format >= 6 ? 64 : 6 | 0x80;
  const TempFile file("strip.las", las.Build());
  EXPECT_EQ(ReadAll(file.path()).classification,
            (std::vector<std::uint8_t>{2, static_cast<std::uint8_t>(las.format >= 6 ? 64 : 6), 0}));
}

INSTANTIATE_TEST_SUITE_P(
    Las, EveryLasFormat,
    ::testing::Values(VersionAndFormat{0, 0}, VersionAndFormat{0, 1}, VersionAndFormat{1, 0},
                      VersionAndFormat{1, 1}, VersionAndFormat{3, 1}, VersionAndFormat{2, 0},
                      VersionAndFormat{2, 1}, VersionAndFormat{2, 2}, VersionAndFormat{2, 3},
                      VersionAndFormat{3, 4}, VersionAndFormat{3, 5}, VersionAndFormat{4, 1},
                      VersionAndFormat{4, 6}, VersionAndFormat{4, 7}, VersionAndFormat{4, 8},
                      VersionAndFormat{4, 9}, VersionAndFormat{4, 10}),
    [](const auto& test) {
      return "v1" + std::to_string(test.param.minor) + "format" + std::to_string(test.param.format);
    });

TEST_P(EveryLasFormat, ReadsTheFlagsOfPoints) {
  LasBytes las = ThreePoints();
  las.minor = GetParam().minor;
  las.format = GetParam().format;
  std::string bytes = las.Build();
  const int shift = las.format >= 6 ? 0 : 5;
  const std::size_t first = las.HeaderBytes() + 15;
  bytes[first] = static_cast<char>(StripCloud::kSynthetic << shift);
  bytes[first + las.RecordBytes()] = static_cast<char>(StripCloud::kWithheld << shift);
  const TempFile file("strip.las", bytes);
  EXPECT_EQ(ReadAll(file.path()).flags,
            (std::vector<std::uint8_t>{StripCloud::kSynthetic, StripCloud::kWithheld, 0}));
}

// Version 1.3 with the header of version 1.2, which does not say where the waveforms begin.
TEST(Las, AShortHeaderOfVersion13) {
  LasBytes las = ThreePoints();
  std::string bytes = las.Build();
  bytes[25] = 3;
  const TempFile file("strip.las", bytes);
  EXPECT_EQ(ReadAll(file.path()).size(), 3u);
  EXPECT_EQ(WrittenAgain(file), bytes);
}

// Before version 1.2, the bytes of the encoding have no meaning.
TEST(Las, OldVersionsHaveSecondsOfWeek) {
  for (const int minor : {0, 1}) {
    LasBytes las = ThreePoints();
    las.minor = minor;
    las.encoding = 1;
    const TempFile file("strip.las", las.Build());
    EXPECT_EQ(ReadAll(file.path()).t_s[0], 381000.125);
  }
}

TEST(Las, AnyEnding) {
  for (const char* name : {"strip.LAS", "strip.Las", "strip.txt", "strip.bin", "strip"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(ReadAll(TempFile(name, ThreePoints().Build()).path()).size(), 3u);
  }
}

TEST(Las, AdjustedTimeBecomesSecondsOfWeekWithoutLosingABit) {
  LasBytes las = ThreePoints();
  las.encoding = 1;
  // The first point is in week 2234, which begins at 2234 x 604800 s minus 1e9 s. The second point
  // is in the next week.
  const double week_s = 2234.0 * 604800.0 - 1e9;
  las.points[0].time_s = week_s + 604799.123456;
  las.points[1].time_s = week_s + 604800.5;
  las.points[2].time_s = week_s + 604799.0;
  const TempFile file("strip.las", las.Build());
  const StripCloud points = ReadAll(file.path());
  EXPECT_EQ(points.t_s[0], las.points[0].time_s - week_s);
  EXPECT_EQ(points.t_s[1], 604800.5);
  EXPECT_EQ(points.t_s[2], 604799.0);
  EXPECT_EQ(WrittenAgain(file), las.Build());
}

TEST(Las, ChunksHaveABound) {
  LasBytes las;
  las.points.resize(70000);
  for (std::size_t i = 0; i < las.points.size(); ++i) {
    las.points[i].x = static_cast<std::int32_t>(i);
  }
  const TempFile file("strip.las", las.Build());
  const auto reader = OpenStrip(file.path());
  EXPECT_EQ(reader->points(), 70000u);
  StripCloud points;
  ASSERT_TRUE(reader->Next(&points));
  EXPECT_EQ(points.size(), 65536u);
  ASSERT_TRUE(reader->Next(&points));
  EXPECT_EQ(points.size(), 70000u - 65536u);
  EXPECT_NEAR(points.p_c[0].x(), 65.536, 1e-12);
  EXPECT_FALSE(reader->Next(&points));
}

TEST(Las, DroppedPointsLeaveCountsAndBounds) {
  LasBytes las = ThreePoints();
  las.minor = 4;
  las.format = 6;
  const TempFile file("strip.las", las.Build());
  LasBytes expected = las;
  expected.points.erase(expected.points.begin() + 1);
  EXPECT_EQ(WrittenAgain(file, false, {false, true, false}), expected.Build());
}

TEST(Las, LaserVectorsAreExtraBytes) {
  LasBytes las = ThreePoints();
  las.vlrs = {ExtraBytesRecord({"ux", "uy", "uz"}, 10)};
  las.extra_bytes = 24;
  for (LasPoint& point : las.points) {
    const double u_m[3] = {1.5, -2.5, 700.25};
    point.extra.assign(reinterpret_cast<const char*>(u_m), sizeof u_m);
  }
  const TempFile file("strip.las", las.Build());
  const auto reader = OpenStrip(file.path());
  EXPECT_TRUE(reader->has_vectors());
  EXPECT_EQ(ReadAll(file.path()).u_s[2], Vector3d(1.5, -2.5, 700.25));
  las.points[1].extra = std::string(24, '\0');
  const TempFile zero("strip.las", las.Build());
  ExpectInvalidIn([&] { ReadAll(zero.path()); }, "point 2: laser vector has zero length",
                  "strip.las");
  const double nan = std::nan("");
  std::memcpy(las.points[1].extra.data() + 8, &nan, sizeof nan);
  const TempFile not_finite("strip.las", las.Build());
  ExpectInvalidIn([&] { ReadAll(not_finite.path()); }, "point 2: laser vector is not finite",
                  "strip.las");
}

TEST(Las, CovarianceIsAddedAfterExistingBytes) {
  LasBytes las = ThreePoints();
  las.vlrs = {{"somebody", 7, "what nobody knows"}, ExtraBytesRecord({"Reflectance"}, 9)};
  las.extra_bytes = 6;  // two of these bytes have no description
  for (LasPoint& point : las.points) point.extra = "abcdef";
  const TempFile file("strip.las", las.Build());
  LasBytes expected = las;
  expected.extra_bytes = 6 + 24;
  std::string undocumented(192, '\0');
  undocumented[3] = 2;
  std::memcpy(undocumented.data() + 4, "undocumented", 12);
  LasRecord described = ExtraBytesRecord(
      {"VarianceX", "VarianceY", "VarianceZ", "CovarianceXY", "CovarianceXZ", "CovarianceYZ"}, 9);
  for (std::size_t at = 160; at < described.content.size(); at += 192) {
    std::memcpy(described.content.data() + at, "of the coordinates, m^2", 23);
  }
  expected.vlrs[1].content += undocumented + described.content;
  const float values[6] = {1.0f, 4.0f, 9.0f, 0.5f, 0.0f, 0.0f};
  for (LasPoint& point : expected.points) {
    point.extra.append(reinterpret_cast<const char*>(values), sizeof values);
  }
  const std::string written = WrittenAgain(file, true);
  EXPECT_EQ(written, expected.Build());
  EXPECT_EQ(WrittenAgain(TempFile("strip.las", written), true), written);
}

TEST(Las, CovarianceMakesTheRecordOfExtraBytes) {
  const TempFile file("strip.las", ThreePoints().Build());
  const TempFile written("strip.las", WrittenAgain(file, true));
  EXPECT_EQ(ReadAll(written.path()).record_bytes, 28u + 24u);
  LasBytes other = ThreePoints();
  other.vlrs = {ExtraBytesRecord({"VarianceY"}, 10)};
  other.extra_bytes = 8;
  const TempFile taken("strip.las", other.Build());
  ExpectInvalidIn([&] { WrittenAgain(taken, true); }, "VarianceY already exist", "strip.las");
}

TEST(Las, DataAfterThePointsMoveWithTheirEnd) {
  LasBytes las = ThreePoints();
  las.minor = 4;
  las.format = 6;
  las.evlrs = {{"somebody", 1, "first"}, {"somebody", 2, "second"}};
  const TempFile file("strip.las", las.Build());
  LasBytes expected = las;
  expected.points.pop_back();
  EXPECT_EQ(WrittenAgain(file, false, {false, false, true}), expected.Build());
}

TEST(Las, WaveformsMoveWithTheEndOfThePoints) {
  LasBytes las = ThreePoints();
  las.minor = 3;
  las.format = 4;
  const auto with_waveforms = [](const LasBytes& points) {
    std::string bytes = points.Build();
    LasBytes::Put(static_cast<std::uint64_t>(bytes.size()), 227, &bytes);
    return bytes + "waveforms";
  };
  const TempFile file("strip.las", with_waveforms(las));
  LasBytes expected = las;
  expected.points.pop_back();
  EXPECT_EQ(WrittenAgain(file, false, {false, false, true}), with_waveforms(expected));
}

std::string BoresightContent(const Vector3d& deg) {
  std::string content(24, '\0');
  for (int i = 0; i < 3; ++i) std::memcpy(content.data() + 8 * i, &deg[i], 8);
  return content;
}

TEST(Las, TheBoresightOfThePointsIsARecord) {
  const Vector3d deg(0.25, -0.5, 1.0);
  const Vector3d rad = deg * std::numbers::pi / 180.0;
  LasBytes las = ThreePoints();
  las.minor = 4;
  las.format = 6;
  las.vlrs = {{"somebody", 7, "what nobody knows"}};
  las.evlrs = {{"somebody", 1, "behind"}};
  const TempFile file("strip.las", las.Build());
  EXPECT_FALSE(OpenStrip(file.path())->boresight_rad());
  const TempFile written("new.las", WrittenAgain(file, false, {}, rad));
  EXPECT_LT((*OpenStrip(written.path())->boresight_rad() - rad).norm(), 1e-15);
  EXPECT_EQ(ReadAll(written.path()).p_c, ReadAll(file.path()).p_c);
  // Only the sizes are compared, because LasBytes leaves the description of the record empty.
  las.vlrs.push_back({"dn", 1, BoresightContent(deg)});
  EXPECT_EQ(ReadWholeFile(written.path()).size(), las.Build().size());

  // A new record replaces the old one, also if the file gets covariances.
  const TempFile again("again.las", WrittenAgain(written, true, {}, Vector3d(2.0 * rad)));
  EXPECT_LT((*OpenStrip(again.path())->boresight_rad() - 2.0 * rad).norm(), 1e-15);
  EXPECT_EQ(ReadAll(again.path()).record_bytes, 30u + 24u);
  const TempFile both("both.las", WrittenAgain(file, true, {}, rad));
  EXPECT_LT((*OpenStrip(both.path())->boresight_rad() - rad).norm(), 1e-15);
  EXPECT_EQ(ReadAll(both.path()).record_bytes, 30u + 24u);
  EXPECT_EQ(ReadAll(both.path()).p_c, ReadAll(file.path()).p_c);
}

TEST(Las, ABadRecordOfTheBoresightIsNamed) {
  const auto expect = [](const std::string& content, const std::string& what) {
    LasBytes las = ThreePoints();
    las.vlrs = {{"dn", 1, content}};
    const TempFile file("strip.las", las.Build());
    ExpectInvalidIn([&] { OpenStrip(file.path()); }, what, "strip.las");
  };
  expect("too short", "the record of the boresight (dn, 1) has 9 bytes of content");
  expect(BoresightContent({0.0, std::nan(""), 0.0}), "has an angle beyond 180 deg");
  expect(BoresightContent({0.0, 0.0, -181.0}), "has an angle beyond 180 deg");
}

TEST(Las, ANewPointMustFitTheGridOfTheFile) {
  const TempFile file("strip.las", ThreePoints().Build());
  const auto reader = OpenStrip(file.path());
  const auto writer = reader->MakeWriter(file.path().parent_path() / "copy.las", {});
  StripCloud points;
  reader->Next(&points);
  points.p_c[0].y() += 3e6;
  ExpectInvalidIn([&] { writer->Append(points); }, "give the file a larger scale factor",
                  "strip.las");
}

void ExpectRefused(const std::string& bytes, const std::string& what,
                   const std::string& name = "strip.las") {
  const TempFile file(name, bytes);
  ExpectInvalidIn(
      [&] {
        const auto reader = OpenStrip(file.path());
        for (StripCloud points; reader->Next(&points);) {
        }
      },
      what, name);
}

template <class T>
void ExpectRefusedWith(const LasBytes& las, std::size_t at, T value, const std::string& what) {
  std::string bytes = las.Build();
  LasBytes::Put(value, at, &bytes);
  ExpectRefused(bytes, what);
}

TEST(LasHeader, ReportsFalseStatements) {
  LasBytes las = ThreePoints();
  las.vlrs = {{"somebody", 7, "what nobody knows"}, ExtraBytesRecord({"Reflectance"}, 9)};
  las.extra_bytes = 4;
  const auto with = [&](std::size_t at, auto value, const std::string& what) {
    SCOPED_TRACE("byte " + std::to_string(at));
    ExpectRefusedWith(las, at, value, what);
  };
  ExpectRefused("", "no rows of numbers");
  ExpectRefused(std::string(300, 'x'), "is not a number");
  with(25, std::uint8_t{5}, "version 1.5 (byte 24) is not supported");
  with(24, std::uint8_t{2}, "version 2.2 (byte 24) is not supported");
  with(94, std::uint16_t{100}, "the header size (byte 94) is 100");
  with(94, std::uint16_t{60000}, "the points begin (byte 96)");
  with(96, std::uint32_t{0}, "the points begin (byte 96) at byte 0");
  with(96, std::uint32_t{4000000000u}, "the points begin (byte 96) at byte 4000000000");
  with(100, std::uint32_t{3}, "variable length record 3 of 3 (byte 100)");
  with(227 + 20, std::uint16_t{65535}, "variable length record 1 of 2");
  with(104, std::uint8_t{6},
       "point format 6 (byte 104) is not supported: version 1.2 allows 0 to 3");
  with(104, std::uint8_t{129},
       "the points are compressed, but the record that says how is missing");
  with(104, std::uint8_t{65}, "point format 65 (byte 104) is not supported");
  with(105, std::uint16_t{27}, "a record has 27 bytes (byte 105)");
  with(105, std::uint16_t{30}, "the described extra bytes need 32");
  with(107, std::uint32_t{4}, "it announces 4 points of 32 bytes");
  with(107, std::uint32_t{4000000000u}, "4000000000 points");
  with(107, std::uint32_t{1}, "64 bytes follow the 1 points");
  with(131, 0.0, "scale factor 0 (byte 131)");
  with(139, std::nan(""), "scale factor (byte 139) is not a finite number");
  with(147, -0.001, "scale factor -0.001 (byte 147)");
  with(155, std::nan(""), "offset (byte 155) is not a finite number");
  with(163, 1e300, "offset 1e+300 (byte 163)");
  const std::size_t descriptor = 227 + 54 + 17 + 54;
  with(descriptor + 2, std::uint8_t{31}, "unknown type 31");
  const std::size_t first = las.Build().size() - 3 * las.RecordBytes();
  with(first + 20, std::nan(""), "GPS time of point 1 is not a finite number");
  with(first + 20, 3.5e8, "if it is adjusted standard time, set the bit");
}

TEST(LasHeader, ReportsFalseStatementsOfVersionFour) {
  LasBytes las = ThreePoints();
  las.minor = 4;
  las.format = 6;
  las.encoding = 1;
  for (LasPoint& point : las.points) point.time_s += 3.5e8;
  las.evlrs = {{"somebody", 1, "first"}};
  const std::size_t end = las.Build().size() - 60 - 5;
  const auto with = [&](std::size_t at, auto value, const std::string& what) {
    SCOPED_TRACE("byte " + std::to_string(at));
    ExpectRefusedWith(las, at, value, what);
  };
  with(107, std::uint32_t{2}, "two different numbers of points");
  with(235, std::uint64_t{375}, "the extended records begin (byte 235) at byte 375");
  with(235, ~std::uint64_t{0}, "beyond the end of the file");
  with(243, std::uint32_t{2}, "2 extended records (byte 243) are promised");
  with(end + 20, ~std::uint64_t{0}, "extended record 1 of 1");
  with(247, ~std::uint64_t{0}, "points of 30 bytes from byte");
  with(375 + 22, 1e10, "GPS time 1e+10 of point 1");
  with(375 + 30 + 22, 1e9, "lies outside the week of the first point");
  LasBytes waveforms = ThreePoints();
  waveforms.minor = 3;
  waveforms.format = 4;
  ExpectRefusedWith(waveforms, 227, std::uint64_t{300}, "the waveforms begin (byte 227)");
}

LasBytes WithExtendedRecords() {
  LasBytes las = ThreePoints();
  las.minor = 4;
  las.format = 6;
  return las;
}

/// Expects that a file with three points is rejected if its header promises `count` extended
/// records from `begin` on. The file has `file_bytes` bytes.
void ExpectRecordsRefused(std::uint32_t count, std::uint64_t begin, std::uint64_t file_bytes,
                          const std::string& what) {
  const testing::TempFolder folder;
  std::string bytes = WithExtendedRecords().Build();
  LasBytes::Put(begin == 0 ? std::uint64_t{bytes.size()} : begin, 235, &bytes);
  LasBytes::Put(count, 243, &bytes);
  folder.Write("strip.las", bytes);
  std::filesystem::resize_file(folder.path() / "strip.las", file_bytes);
  testing::ExpectInvalidIn([&] { OpenStrip(folder.path() / "strip.las"); }, what, "strip.las");
}

TEST(LasHeader, RecordsWithoutEndAreRefused) {
  constexpr std::uint64_t kLarge = std::uint64_t{300} << 30;
  ExpectRecordsRefused(4294967295u, 0, kLarge, "4294967295 extended records (byte 243)");
  ExpectRecordsRefused(4294967295u, 0, 1000, "each has at least 60");
  ExpectRecordsRefused(10001, 0, kLarge, "at most 10000 are read");
  ExpectRecordsRefused(1, kLarge - 60, kLarge, "belong to no record");
  ExpectRecordsRefused(1, 0, kLarge, "belong to no record");
  ExpectRecordsRefused(1, kLarge + 1, kLarge, "beyond the end of the file");
  LasBytes las = ThreePoints();
  ExpectRefusedWith(las, 100, std::uint32_t{4000000000u}, "4000000000 variable length records");
  for (int i = 0; i < 10001; ++i) las.vlrs.push_back({"somebody", 7, ""});
  ExpectRefused(las.Build(), "at most 10000 are read");
}

TEST(LasHeader, LazIsRecognisedByItsRecord) {
  LasBytes las = ThreePoints();
  las.vlrs = {{"laszip encoded", 22204, "x"}};
  ExpectRefused(las.Build(), "the record of the compression has 1 bytes");
}

TEST(LasHeader, RejectsOtherFiles) {
  ExpectRefused(std::string("ply\0\1\2", 6), "strips must be LAS or LAZ, or text of t, x, y, z",
                "strip.ply");
  ExpectRefused("x", "'x' is not a number", "strip.ply");
}

}  // namespace dn::lidar_test
