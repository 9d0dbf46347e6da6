#include <dn/error.h>
#include <dn/lidar/strip_io.h>
#include <gtest/gtest.h>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::lidar_test {

using Eigen::Vector3d;

StripCloud TwoPoints() {
  StripCloud points;
  points.p_c = {{1000.12344, -2000.5, 431.0}, {1001.0, -2001.0, 432.0}};
  points.t_s = {381000.1234567, 381000.1234617};
  points.u_s = {{1.0 / 3.0, -17.0, 421.123456789012}, {0.1, 0.2, 400.3}};
  points.source = {3, 4};
  return points;
}

TEST(NewLasStrip, ReadsBackAsItWasGiven) {
  const testing::TempFile file("new.las", "");
  const StripCloud given = TwoPoints();
  const auto writer = NewLasStrip(file.path(), {.offset_m = {1000.0, -2000.0, 400.0}});
  writer->Append(given);
  writer->Append(given);
  writer->Finish();

  const auto reader = OpenStrip(file.path());
  EXPECT_EQ(reader->points(), 4u);
  EXPECT_TRUE(reader->has_time());
  EXPECT_TRUE(reader->has_vectors());
  StripCloud points;
  ASSERT_TRUE(reader->Next(&points));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(points.t_s[i], given.t_s[i % 2]);
    EXPECT_EQ(points.u_s[i], given.u_s[i % 2]);
    EXPECT_EQ(points.source[i], given.source[i % 2]);
    EXPECT_LE((points.p_c[i] - given.p_c[i % 2]).cwiseAbs().maxCoeff(), 0.5e-4 + 1e-9);
  }
}

TEST(NewLasStrip, KeepsTheBeamsOfAScanner) {
  for (const char* name : {"beams.las", "beams.laz"}) {
    const testing::TempFile file(name, "");
    StripCloud given = TwoPoints();
    given.beam = {31, 0};
    const auto writer =
        NewLasStrip(file.path(), {.offset_m = {1000.0, -2000.0, 400.0}}, /*with_beam=*/true);
    writer->Append(given);
    writer->Finish();
    StripCloud points;
    ASSERT_TRUE(OpenStrip(file.path())->Next(&points));
    EXPECT_EQ(points.beam, given.beam) << name;
    EXPECT_EQ(points.u_s, given.u_s);
  }
}

TEST(NewLasStrip, ABeamThatDoesNotExistIsRefused) {
  const testing::TempFile file("beams.las", "");
  StripCloud given = TwoPoints();
  given.beam = {31, 1024};
  const auto writer =
      NewLasStrip(file.path(), {.offset_m = {1000.0, -2000.0, 400.0}}, /*with_beam=*/true);
  writer->Append(given);
  writer->Finish();
  StripCloud points;
  testing::ExpectInvalid([&] { OpenStrip(file.path())->Next(&points); }, "point 2: beam 1024", 0);
}

TEST(NewLasStrip, KeepsReturnsClassesFlagsAndIntensities) {
  const testing::TempFile file("returns.las", "");
  StripCloud given = TwoPoints();
  given.return_number = {2, 5};
  given.returns_after = {3, 0};
  given.classification = {18, 2};
  given.flags = {StripCloud::kWithheld, 0};
  given.intensity = {65535, 7};
  const auto writer = NewLasStrip(file.path(), {.offset_m = {1000.0, -2000.0, 400.0}});
  writer->Append(given);
  writer->Finish();

  StripCloud points;
  ASSERT_TRUE(OpenStrip(file.path())->Next(&points));
  EXPECT_EQ(points.return_number, given.return_number);
  EXPECT_EQ(points.returns_after, given.returns_after);
  EXPECT_EQ(points.classification, given.classification);
  EXPECT_EQ(points.flags, given.flags);
  EXPECT_EQ(points.intensity, given.intensity);
}

TEST(NewLasStrip, MayHaveNoPoints) {
  const testing::TempFile file("empty.las", "");
  NewLasStrip(file.path(), {})->Finish();
  EXPECT_EQ(OpenStrip(file.path())->points(), 0u);
}

TEST(NewLasStrip, APointBeyondTheGridIsAnError) {
  const testing::TempFile file("far.las", "");
  const auto writer = NewLasStrip(file.path(), {});
  StripCloud far = TwoPoints();
  far.p_c[1].x() = 3e5;
  EXPECT_THROW(writer->Append(far), InvalidInput);
}

}  // namespace dn::lidar_test
