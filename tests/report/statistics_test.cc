#include <dn/error.h>
#include <dn/report/json.h>
#include <dn/report/statistics.h>
#include <gtest/gtest.h>

namespace dn::report_test {

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

TEST(Statistics, AutocorrelationReachesAQuarterOfTheSeries) {
  std::vector<double> t_s, values;  // period 4: 1, 1, -1, -1
  for (int i = 0; i < 40; ++i) {
    t_s.push_back(i);
    values.push_back(i % 4 < 2 ? 1.0 : -1.0);
  }
  const SeriesStatistics s = DescribeSeries("a", "x", t_s, values);
  ASSERT_EQ(s.autocorrelation.size(), 4U);
  EXPECT_EQ(s.autocorrelation[0].first, 1);
  EXPECT_EQ(s.autocorrelation[0].second, s.lag1_correlation);
  EXPECT_EQ(s.autocorrelation[1].first, 2);
  EXPECT_NEAR(s.autocorrelation[1].second, -38.0 / 40.0, kRounding);
  EXPECT_EQ(s.autocorrelation[3].first, 10);
}

TEST(Statistics, WorstEpochsAreByStandardisedSize) {
  const SeriesStatistics s =
      DescribeSeries("a", "x", {1.0, 2.0, 3.0, 4.0}, {1.0, -3.0, 2.0, 0.5}, {1.0, 9.0, 1.0, 0.0});
  EXPECT_NEAR(s.expected_variance, 11.0 / 4.0, kRounding);
  ASSERT_EQ(s.worst_epochs.size(), 3U) << "a value without redundancy is ignored";
  EXPECT_EQ(s.worst_epochs[0].t_s, 3.0);
  EXPECT_EQ(s.worst_epochs[1].t_s, 1.0) << "the earlier one of equal size";
  EXPECT_EQ(s.worst_epochs[2].t_s, 2.0);
  EXPECT_EQ(s.worst, 2.0) << "in its own sigmas, not the largest value";
  EXPECT_EQ(s.worst_t_s, 3.0);
}

TEST(Statistics, LengthsThatDifferAreRefused) {
  EXPECT_THROW(DescribeSeries("a", "x", {1.0}, {1.0, 2.0}), InvalidInput);
  EXPECT_THROW(DescribeSeries("a", "x", {1.0}, {1.0}, {1.0, 1.0}), InvalidInput);
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

}  // namespace dn::report_test
