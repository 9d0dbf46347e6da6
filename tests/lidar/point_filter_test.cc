#include <dn/lidar/point_filter.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dn::lidar_test {

std::string Reason(const PointFilter& filter, std::uint8_t point_class, std::uint8_t flags) {
  StripCloud points;
  points.p_c.resize(1);
  points.classification = {point_class};
  points.flags = {flags};
  const char* reason = DropReason(filter, points, 0);
  return reason == nullptr ? "" : reason;
}

TEST(PointFilter, NoiseAndWithheldPointsAreNotUsed) {
  const PointFilter all;
  for (const int ground : {0, 1, 2, 6, 8, 12, 17, 19})
    EXPECT_EQ(Reason(all, static_cast<std::uint8_t>(ground), 0), "");
  EXPECT_EQ(Reason(all, 7, 0), "classified as noise");
  EXPECT_EQ(Reason(all, 18, 0), "classified as noise");
  EXPECT_EQ(Reason(all, 2, StripCloud::kWithheld), "withheld");
  EXPECT_EQ(Reason(all, 2, StripCloud::kSynthetic), "synthetic");
  EXPECT_EQ(Reason(all, 2, 2), "");  // a key point of a model
  EXPECT_EQ(Reason(all, 2, 8), "");  // in the overlap of two strips
}

TEST(PointFilter, NamedClassesMayBeNoise) {
  const PointFilter noise{.classes = {7}};
  EXPECT_EQ(Reason(noise, 7, 0), "");
  EXPECT_EQ(Reason(noise, 18, 0), "of another class");
  EXPECT_EQ(Reason(noise, 7, StripCloud::kWithheld), "withheld");
}

TEST(PointFilter, PointsWithoutClassOrFlagsAreUsed) {
  StripCloud points;
  points.p_c.resize(1);
  EXPECT_EQ(DropReason({}, points, 0), nullptr);
}

}  // namespace dn::lidar_test
