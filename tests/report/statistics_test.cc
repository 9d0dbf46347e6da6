#include <dn/report/statistics.h>
#include <gtest/gtest.h>

namespace dn {
namespace {

constexpr double kRounding = 1e-15;  // a few additions of numbers of order one

// 1, 2, 4, 1: mean 2; deviations -1, 0, 2, -1; variance 6/4; lag one (0 + 0 - 2)/4; squares 22/4.
TEST(Statistics, HandComputedSeries) {
  const SeriesStatistics s =
      DescribeSeries("gnss", "up", {10.0, 11.0, 12.0, 13.0}, {1.0, 2.0, 4.0, 1.0});
  EXPECT_EQ(s.sensor, "gnss");
  EXPECT_EQ(s.axis, "up");
  EXPECT_EQ(s.count, 4);
  EXPECT_NEAR(s.mean, 2.0, kRounding);
  EXPECT_NEAR(s.variance, 1.5, kRounding);
  EXPECT_NEAR(s.lag1_correlation, -1.0 / 3.0, kRounding);
  EXPECT_NEAR(s.mean_square, 5.5, 2 * kRounding);
  EXPECT_EQ(s.worst, 4.0);
  EXPECT_EQ(s.worst_t_s, 12.0);
}

TEST(Statistics, WorstKeepsItsSign) {
  const SeriesStatistics s = DescribeSeries("a", "x", {1.0, 2.0, 3.0}, {1.0, -3.0, 2.0});
  EXPECT_EQ(s.worst, -3.0);
  EXPECT_EQ(s.worst_t_s, 2.0);
}

TEST(Statistics, EmptySeriesGivesZeros) {
  const SeriesStatistics s = DescribeSeries("a", "x", {}, {});
  EXPECT_EQ(s.count, 0);
  EXPECT_EQ(s.mean, 0.0);
  EXPECT_EQ(s.variance, 0.0);
  EXPECT_EQ(s.lag1_correlation, 0.0);
  EXPECT_EQ(s.mean_square, 0.0);
  EXPECT_EQ(s.worst, 0.0);
}

TEST(Statistics, ConstantSeriesHasNoCorrelation) {
  const SeriesStatistics s = DescribeSeries("a", "x", {1.0, 2.0}, {0.5, 0.5});
  EXPECT_EQ(s.variance, 0.0);
  EXPECT_EQ(s.lag1_correlation, 0.0);
  EXPECT_EQ(s.mean_square, 0.25);
}

TEST(Statistics, JsonGroupsAxesUnderTheirSensor) {
  const Json json = StatisticsToJson({DescribeSeries("gnss", "east", {0.0}, {2.0}),
                                      DescribeSeries("gnss", "north", {0.0}, {3.0}),
                                      DescribeSeries("imu", "x", {5.0}, {-1.0})});
  EXPECT_EQ(json.size(), 2U);
  EXPECT_EQ(json["gnss"]["east"]["nis"], 4.0);
  EXPECT_EQ(json["gnss"]["north"]["mean"], 3.0);
  EXPECT_EQ(json["imu"]["x"]["worst"], -1.0);
  EXPECT_EQ(json["imu"]["x"]["worst_t_s"], 5.0);
  EXPECT_EQ(json["imu"]["x"]["count"], 1);
  EXPECT_EQ(StatisticsToJson({}).dump(), "{}");
}

}  // namespace
}  // namespace dn
