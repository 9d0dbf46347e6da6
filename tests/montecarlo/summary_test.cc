#include <dn/error.h>
#include <dn/montecarlo/summary.h>
#include <dn/sim/random.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::montecarlo_test {

/// Draws records whose errors have the stated covariances times a scale; 1 is consistent.
std::vector<FlightRecord> Records(int flights, double scale) {
  Random random(5, "records");
  std::vector<FlightRecord> records;
  for (int k = 1; k <= flights; ++k) {
    FlightRecord record;
    record.seed = static_cast<std::uint64_t>(k);
    const Eigen::Vector3d sigma_rad(1e-5, 2e-5, 5e-5);
    record.boresight_covariance_rad2 = sigma_rad.cwiseAbs2().asDiagonal();
    record.boresight_error_rad = scale * sigma_rad.cwiseProduct(random.Normal3());
    record.redundancy = 5000;
    record.chi2 = 0.0;
    for (long i = 0; i < record.redundancy; ++i) {
      record.chi2 += std::pow(scale * random.Normal(), 2);
    }
    for (int e = 0; e < 200; ++e) {
      EpochErrors epoch;
      epoch.t_s = e;
      for (std::size_t q = 0; q < kQuantities.size(); ++q) {
        epoch.sigmas[q] = scale * random.Normal3();
        epoch.nees[q] = epoch.sigmas[q].squaredNorm();
      }
      record.epochs.push_back(epoch);
    }
    SeriesStatistics series;
    series.sensor = "gnss position";
    series.axis = "east";
    series.count = 1000;
    series.mean_square = scale * scale;
    series.lag1_correlation = scale > 1.0 ? 0.5 : 0.0;
    record.innovations.push_back(series);
    records.push_back(record);
  }
  return records;
}

TEST(MonteCarloSummary, HonestCovariancesAreInsideEveryBand) {
  const MonteCarloSummary summary = Summarise(Records(60, 1.0));
  EXPECT_TRUE(summary.consistent()) << FormatTable(summary, "made up");
  EXPECT_EQ(summary.flights, 60);
  for (const TrajectoryConsistency& c : summary.trajectory) {
    EXPECT_NEAR(c.mean_nees_per_dof, 1.0, 0.03) << c.quantity;
    EXPECT_LT(c.share_outside, 0.05) << c.quantity << ": 1 % of 200 epochs is expected";
  }
  EXPECT_TRUE(summary.innovations[0].variance_ratio.ok());
  EXPECT_TRUE(summary.innovations[0].lag1.ok());
}

TEST(MonteCarloSummary, OverconfidenceIsSeenEverywhere) {
  const MonteCarloSummary summary = Summarise(Records(60, 1.3));
  EXPECT_FALSE(summary.consistent());
  EXPECT_FALSE(summary.boresight.nees_per_dof.ok());
  EXPECT_FALSE(summary.chi2_per_dof.ok());
  EXPECT_FALSE(summary.innovations[0].variance_ratio.ok());
  EXPECT_FALSE(summary.innovations[0].lag1.ok());
  for (const TrajectoryConsistency& c : summary.trajectory) EXPECT_GT(c.share_above, 0.9);
}

TEST(MonteCarloSummary, PessimismIsSeenToo) {
  const MonteCarloSummary summary = Summarise(Records(60, 0.7));
  EXPECT_FALSE(summary.boresight.nees_per_dof.ok());
  for (const TrajectoryConsistency& c : summary.trajectory) {
    EXPECT_GT(c.share_outside, 0.9);
    EXPECT_EQ(c.share_above, 0.0);
  }
}

TEST(MonteCarloSummary, FailuresAreCountedAndNamed) {
  std::vector<FlightRecord> records = Records(10, 1.0);
  records[3].failure = "no attitude";
  const MonteCarloSummary summary = Summarise(records);
  EXPECT_EQ(summary.flights, 9);
  ASSERT_EQ(summary.failure_messages.size(), 1U);
  EXPECT_EQ(summary.failure_messages[0], "seed 4: no attitude");
  EXPECT_FALSE(summary.consistent());
  for (FlightRecord& record : records) record.failure = "no attitude";
  EXPECT_THROW(Summarise(records), InvalidInput);
}

TEST(MonteCarloSummary, RejectedModelsAreNamed) {
  std::vector<FlightRecord> records = Records(10, 1.0);
  records[3].contradiction = "the antenna is elsewhere";
  const MonteCarloSummary summary = Summarise(records);
  EXPECT_DOUBLE_EQ(summary.share_contradicted.value, 0.1);
  const std::string expected = "seed 4: the antenna is elsewhere";
  EXPECT_EQ(summary.contradictions, std::vector<std::string>{expected});
  EXPECT_NE(FormatTable(summary, "made up").find(expected), std::string::npos);
}

TEST(FlightRecord, SurvivesItsFile) {
  FlightRecord record = Records(1, 1.0).front();
  record.epochs[7].nees[3] = std::nan("");
  record.epochs[7].sigmas[3].setConstant(std::nan(""));
  const std::string text = ToJson(record).dump();
  const FlightRecord back = FlightRecordFromJson(Json::parse(text));
  EXPECT_EQ(ToJson(back).dump(), text);
  EXPECT_EQ(back.boresight_error_rad, record.boresight_error_rad);
  EXPECT_TRUE(std::isnan(back.epochs[7].nees[3]));
  EXPECT_EQ(back.innovations[0].axis, "east");
}

}  // namespace dn::montecarlo_test
