#include <dn/geo/read_file.h>
#include <dn/lidar/strip_io.h>
#include <gtest/gtest.h>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::lidar_test {

using Eigen::Vector3d;
using testing::ExpectInvalid;
using testing::TempFile;

constexpr const char* kTwoPoints =
    "# t, x, y, z, ux, uy, uz\n"
    "381000.5, 1, 2, 3, 10, 20, 30.5\n"
    "381000.25 4 5 6 0 0 700\n";

TEST(StripText, IsReadWithItsVectors) {
  const TempFile file("strip.txt", kTwoPoints);
  const auto reader = OpenStrip(file.path());
  EXPECT_TRUE(reader->has_vectors());
  StripCloud points;
  ASSERT_TRUE(reader->Next(&points));
  EXPECT_EQ(points.t_s, (std::vector<double>{381000.5, 381000.25}));
  EXPECT_EQ(points.p_c[1], Vector3d(4, 5, 6));
  EXPECT_EQ(points.u_s[0], Vector3d(10, 20, 30.5));
  EXPECT_TRUE(points.records.empty());
  EXPECT_FALSE(reader->Next(&points));
}

TEST(StripText, TheLastColumnMayBeTheBeam) {
  const TempFile file("strip.txt", "381000.5, 1, 2, 3, 10, 20, 30.5, 4\n");
  const auto reader = OpenStrip(file.path());
  StripCloud points;
  ASSERT_TRUE(reader->Next(&points));
  EXPECT_EQ(points.beam, std::vector<std::uint16_t>{4});
  points.covariance_c_m2 = {Eigen::Matrix3d::Identity()};
  const auto copy = file.path().parent_path() / "copy_with_beam.txt";
  const auto writer = reader->MakeWriter(copy, {.covariance = true});
  writer->Append(points);
  writer->Finish();
  EXPECT_EQ(ReadWholeFile(copy), "381000.5, 1, 2, 3, 10, 20, 30.5, 1, 0, 0, 1, 0, 1, 4\n");
  ASSERT_TRUE(OpenStrip(copy)->Next(&points));
  EXPECT_EQ(points.beam, std::vector<std::uint16_t>{4});
  EXPECT_EQ(points.covariance_c_m2.size(), 1u);
}

TEST(StripText, ABeamIsANumberFrom0) {
  for (const char* beam : {"-1", "1.5", "1024"}) {
    const TempFile file("strip.txt",
                        "381000.5, 1, 2, 3, 10, 20, 30.5, " + std::string(beam) + "\n");
    StripCloud points;
    ExpectInvalid([&] { OpenStrip(file.path())->Next(&points); }, "beam", 1);
  }
}

TEST(StripText, IsWrittenWithEveryDigitAndItsCovariance) {
  const TempFile file("strip.txt", kTwoPoints);
  const auto reader = OpenStrip(file.path());
  StripCloud points;
  reader->Next(&points);
  points.p_c[0].x() = 1.0 / 3.0;
  Eigen::Matrix3d C;
  C << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  points.covariance_c_m2 = {C, C};
  const auto copy = file.path().parent_path() / "copy.txt";
  const auto writer = reader->MakeWriter(copy, {.covariance = true});
  writer->Append(points);
  EXPECT_FALSE(std::filesystem::exists(copy));
  writer->Finish();
  EXPECT_EQ(ReadWholeFile(copy),
            "381000.5, 0.3333333333333333, 2, 3, 10, 20, 30.5, 1, 2, 3, 4, 5, 6\n"
            "381000.25, 4, 5, 6, 0, 0, 700, 1, 2, 3, 4, 5, 6\n");
  StripCloud again;
  ASSERT_TRUE(OpenStrip(copy)->Next(&again));
  EXPECT_EQ(again.p_c[0], points.p_c[0]);
  EXPECT_EQ(again.covariance_c_m2[1], C);
}

TEST(StripText, BadRowsAreNamedByTheirLine) {
  const auto expect = [](const std::string& row, const std::string& what) {
    const TempFile file("strip.txt", "1, 2, 3, 4, 5, 6, 7\n" + row + "\n");
    ExpectInvalid(
        [&] {
          const auto reader = OpenStrip(file.path());
          for (StripCloud points; reader->Next(&points);) {
          }
        },
        what, 2);
  };
  expect("1, 2, 3, 4", "row has 4 columns");
  expect("1e9, 2, 3, 4, 5, 6, 7", "cannot be GPS seconds of week");
  expect("1, 4e7, 3, 4, 5, 6, 7", "a coordinate exceeds 3e7 m");
  expect("1, 2, 3, 4, 0, 0, 0", "zero length");
  expect("1, 2, 3, 4, 5, 6, 7e6", "is it in millimetres");
  expect("1, 2, x, 4, 5, 6, 7", "'x' is not a number");
}

TEST(StripCloud, DropsFromEveryArray) {
  StripCloud points;
  points.t_s = {1, 2, 3};
  points.p_c = {Vector3d::Zero(), Vector3d::Ones(), Vector3d::Zero()};
  points.source = {1, 2, 3};
  points.records = "aabbcc";
  points.record_bytes = 2;
  points.Drop({true, false, false});
  EXPECT_EQ(points.size(), 2u);
  EXPECT_EQ(points.t_s, (std::vector<double>{2, 3}));
  EXPECT_EQ(points.source, (std::vector<std::uint16_t>{2, 3}));
  EXPECT_EQ(points.records, "bbcc");
  EXPECT_TRUE(points.u_s.empty());
}

}  // namespace dn::lidar_test
