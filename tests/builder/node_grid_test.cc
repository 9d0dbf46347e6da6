#include <dn/builder/node_grid.h>
#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dn::builder_test {

using ::testing::DoubleNear;
using ::testing::Pointwise;

constexpr double kRounding = 1e-12;  // rounding of times of about 10 s

/// Returns samples every dt_s from 0 to end_s.
ImuData EvenImu(double end_s, double dt_s) {
  ImuData imu;
  imu.nominal_dt_s = dt_s;
  for (int k = 1; k * dt_s <= end_s + 1e-9; ++k) imu.samples.push_back({k * dt_s, dt_s});
  return imu;
}

void ExpectTimes(const std::vector<double>& actual, const std::vector<double>& expected) {
  EXPECT_THAT(actual, Pointwise(DoubleNear(kRounding), expected));
}

TEST(NodeGrid, GnssEpochsAreNodesAndTheRestIsDividedEqually) {
  NodeGridOptions options;
  options.max_spacing_s = 1.0;
  ExpectTimes(NodeTimes(EvenImu(6.0, 0.1), {0.0, 5.0}, {1.0, 3.5}, {}, options),
              {0.0, 1.0, 1.0 + 2.5 / 3.0, 1.0 + 5.0 / 3.0, 3.5, 4.25, 5.0});
}

TEST(NodeGrid, DenseIntervalsHaveTheirRateUpToTheNextForcedNode) {
  NodeGridOptions options;
  options.rate_in_strips_hz = 4.0;
  ExpectTimes(NodeTimes(EvenImu(6.0, 0.1), {0.0, 4.0}, {1.0, 2.0, 3.0}, {{1.2, 1.4}}, options),
              {0.0, 1.0, 1.25, 1.5, 1.75, 2.0, 3.0, 4.0});
}

TEST(NodeGrid, DenseNeverWidensTheSpacing) {
  NodeGridOptions options;
  options.rate_in_strips_hz = 0.1;
  ExpectTimes(NodeTimes(EvenImu(6.0, 0.1), {0.0, 2.0}, {}, {{0.0, 2.0}}, options), {0.0, 1.0, 2.0});
}

TEST(NodeGrid, ASpacingThatRoundingMakesTooLongIsNotDivided) {
  NodeGridOptions options;
  options.rate_in_strips_hz = 10.0;
  const std::vector<double> gnss{381000.1, 381000.2, 381000.3};
  ImuData imu = EvenImu(1.0, 0.1);
  for (ImuSample& sample : imu.samples) sample.t_s += 381000.0;
  EXPECT_EQ(NodeTimes(imu, {381000.0, 381000.4}, gnss, {{381000.0, 381001.0}}, options).size(), 5U);
}

TEST(NodeGrid, GnssEpochsOutsideTheSpanAreIgnored) {
  ExpectTimes(NodeTimes(EvenImu(6.0, 0.1), {2.0, 3.0}, {1.0, 2.0, 2.5, 3.0, 4.0}, {}, {}),
              {2.0, 2.5, 3.0});
}

TEST(NodeGrid, EpochsWithinAMicrosecondAreOneNode) {
  ExpectTimes(NodeTimes(EvenImu(6.0, 0.1), {0.0, 1.0}, {0.5, 0.5 + 5e-7}, {}, {}), {0.0, 0.5, 1.0});
}

TEST(NodeGrid, EndsOfGapsAreNodes) {
  ImuData imu = EvenImu(3.0, 0.1);
  imu.gaps = {{0.3, 0.7}, {2.9, 9.0}};
  ExpectTimes(NodeTimes(imu, {0.0, 2.0}, {1.0}, {}, {}), {0.0, 0.3, 0.7, 1.0, 2.0});
}

TEST(NodeGrid, NothingStandsInsideAGap) {
  ImuData imu = EvenImu(9.0, 0.1);
  imu.gaps = {{0.3, 4.7}};
  NodeGridOptions options;
  options.rate_in_strips_hz = 10.0;
  ExpectTimes(NodeTimes(imu, {0.0, 5.0}, {0.2, 0.3, 0.5, 4.0, 4.7}, {{1.0, 4.0}}, options),
              {0.0, 0.2, 0.3, 4.7, 5.0});
}

TEST(NodeGrid, RawHasANodeAtEveryImuEpochAndNoneInBetween) {
  NodeGridOptions options;
  options.every_imu_epoch = true;
  options.rate_in_strips_hz = 1000.0;
  ExpectTimes(NodeTimes(EvenImu(2.0, 0.25), {0.25, 1.0}, {0.6}, {{0.0, 2.0}}, options),
              {0.25, 0.5, 0.6, 0.75, 1.0});
}

TEST(NodeGrid, RejectsBadOptionsAndAnEmptySpan) {
  const ImuData imu = EvenImu(2.0, 0.1);
  for (const double bad : {0.0, -1.0}) {
    NodeGridOptions rate, spacing;
    rate.rate_in_strips_hz = bad;
    spacing.max_spacing_s = bad;
    EXPECT_THROW(NodeTimes(imu, {0.0, 1.0}, {}, {}, rate), InvalidConfig);
    EXPECT_THROW(NodeTimes(imu, {0.0, 1.0}, {}, {}, spacing), InvalidConfig);
  }
  EXPECT_THROW(NodeTimes(imu, {1.0, 1.0}, {}, {}, {}), InvalidInput);
  EXPECT_THROW(NodeTimes(imu, {1.0, 0.5}, {}, {}, {}), InvalidInput);
}

TEST(NodeGrid, NodeBefore) {
  const std::vector<double> t{1.0, 2.0, 4.0};
  EXPECT_EQ(NodeBefore(t, 0.0), 0U);
  EXPECT_EQ(NodeBefore(t, 1.0), 0U);
  EXPECT_EQ(NodeBefore(t, 1.999), 0U);
  EXPECT_EQ(NodeBefore(t, 2.0), 1U);
  EXPECT_EQ(NodeBefore(t, 3.9), 1U);
  EXPECT_EQ(NodeBefore(t, 4.0), 2U);
  EXPECT_EQ(NodeBefore(t, 99.0), 2U);
}

TEST(NodeGrid, ClustersOfEpochs) {
  const auto clusters = ClusterEpochs({9.0, 1.0, 2.0, 7.0, 3.5}, 2.0);
  ASSERT_EQ(clusters.size(), 2U);
  EXPECT_EQ(clusters[0].t0_s, 1.0);
  EXPECT_EQ(clusters[0].t1_s, 3.5);
  EXPECT_EQ(clusters[1].t0_s, 7.0);
  EXPECT_EQ(clusters[1].t1_s, 9.0);
  EXPECT_TRUE(ClusterEpochs({}, 1.0).empty());
}

TEST(NodeGrid, MoreNodesThanFitIntoMemoryAreRefused) {
  NodeGridOptions options;
  for (const double rate_hz : {1e6, 1e20, 1e300}) {
    options.rate_in_strips_hz = rate_hz;
    EXPECT_THROW(NodeTimes(EvenImu(6.0, 0.1), {0.0, 5.0}, {}, {{0.0, 5.0}}, options),
                 InvalidConfig);
  }
}

}  // namespace dn::builder_test
