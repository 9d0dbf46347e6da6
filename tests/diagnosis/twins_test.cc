#include "twins.h"

#include <dn/report/distributions.h>
#include <dn/sim/random.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "explained_flight.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using testing::DroneScenario;

constexpr Eigen::Index kPlaces = 20;
constexpr int kTwins = 200;

/// Draws normal, correlated location statistics, and evidence that is not normal.
ResidualSummary Drawn(Random* random) {
  ResidualSummary appearance;
  appearance.locations.resize(kPlaces);
  const double common = random->Normal();
  for (Eigen::Index k = 0; k < kPlaces; ++k) {
    appearance.locations[k] = 3.0 + 2.0 * (0.5 * common + random->Normal());
  }
  appearance.log_evidence.resize(2);
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double x = random->Normal();
    appearance.log_evidence[k] = 0.5 * x * x - 1.0;
  }
  return appearance;
}

ReplicateSet DrawReplicates(Random* random) {
  ReplicateSet twins;
  for (int k = 0; k < kTwins; ++k) twins.all.push_back(Drawn(random));
  return twins;
}

TEST(CompareWithReplicates, IsAsOftenSmallAsItSays) {
  constexpr long kFlights = 400;
  Random random(7, "flights without a gap");
  const ReplicateSet twins = DrawReplicates(&random);
  long below_half = 0;
  for (long k = 0; k < kFlights; ++k) {
    if (CompareWithReplicates(Drawn(&random), twins).p_value <= 0.5) ++below_half;
  }
  // All flights use the same 100 ranking replicates. Their own share below a half is random with a
  // standard deviation of 5 %.
  const Interval usual = BinomialInterval(0.9999, 80, 0.5);
  EXPECT_TRUE(usual.Contains(static_cast<double>(below_half) / kFlights)) << below_half;
}

TEST(CompareWithReplicates, IsRightOverManySetsOfTwins) {
  constexpr long kFlights = 150;
  long small = 0;
  for (long k = 0; k < kFlights; ++k) {
    Random random(static_cast<std::uint64_t>(k), "flight and twins");
    const ReplicateSet twins = DrawReplicates(&random);
    if (CompareWithReplicates(Drawn(&random), twins).p_value <= 0.1) ++small;
  }
  const Interval usual = BinomialInterval(0.9999, kFlights, 0.1);
  EXPECT_TRUE(usual.Contains(static_cast<double>(small) / kFlights)) << small;
}

TEST(CompareWithReplicates, FindsThePlaceThatDeparts) {
  Random random(3, "a flight with a gap");
  const ReplicateSet twins = DrawReplicates(&random);
  ResidualSummary flight = Drawn(&random);
  flight.locations[4] += 20.0;
  const ReplicateTest test = CompareWithReplicates(flight, twins);
  constexpr double kLeast = 1.0 / 101.0;  // 100 replicates rank
  EXPECT_DOUBLE_EQ(test.p_largest, kLeast);
  EXPECT_DOUBLE_EQ(test.p_adjusted[4], kLeast);
  EXPECT_LE(test.p_value, 3.0 * kLeast);
  for (Eigen::Index k = 0; k < kPlaces; ++k) {
    if (k != 4) {
      EXPECT_GT(test.p_adjusted[k], 0.02) << k;
    }
  }
}

TEST(CompareWithReplicates, EvidenceAloneShowsAGap) {
  Random random(3, "a flight with a gap");
  const ReplicateSet twins = DrawReplicates(&random);
  ResidualSummary flight = Drawn(&random);
  flight.log_evidence[1] = 40.0;
  const ReplicateTest test = CompareWithReplicates(flight, twins);
  EXPECT_DOUBLE_EQ(test.p_library, 1.0 / 101.0);
  EXPECT_LT(test.evidence_95, 40.0);
}

TEST(TestReplicateConsistency, AgreeWhereTheyAreAlike) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed, "twins");
    EXPECT_GT(TestReplicateConsistency(DrawReplicates(&random)), 1e-4) << seed;
  }
}

TEST(TestReplicateConsistency, DifferWhereSomeAreOthers) {
  Random random(1, "twins");
  ReplicateSet twins = DrawReplicates(&random);
  for (std::size_t k = 2 * twins.all.size() / 3; k < twins.all.size(); ++k) {
    twins.all[k].locations[0] += 8.0;
  }
  EXPECT_LT(TestReplicateConsistency(twins), 1e-4);
}

/// A flight compared with its replicates.
struct ComparedReplicates {
  explicit ComparedReplicates(const std::string& effects) {
    const Flight flight = Simulate(DroneScenario(effects), {}).flight;
    const GapOptions options;
    const ExtendedModelFitter model_fitter(flight, options);
    test = model_fitter.Test(model_fitter.Explain({}), kTwins, &appearance, &twins, &statistics);
  }

  double Z(const std::string& name) const {
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      if (StatisticName(statistics[k]) == name) return test.z[static_cast<Eigen::Index>(k)];
    }
    return std::nan("");
  }

  ResidualSummary appearance;
  ReplicateSet twins;
  std::vector<LocationStatistic> statistics;
  ReplicateTest test;
};

TEST(Locations, LinearTwinsAreAlike) {
  const ComparedReplicates without("");
  EXPECT_GT(TestReplicateConsistency(without.twins), 1e-4);
  EXPECT_GT(without.test.p_value, 0.02);
  EXPECT_LT(std::abs(without.Z("gnss position east, mean square")), 4.0);
}

TEST(Locations, NoiseOfGnssShowsInGnss) {
  const ComparedReplicates noisy("effects: [{effect: gnss_noise_scale, value: 1.5}]");
  EXPECT_LE(noisy.test.p_value, 0.03);
  for (const char* axis : {"east", "north", "up"}) {
    EXPECT_GT(noisy.Z(std::string("gnss position ") + axis + ", mean square"), 5.0) << axis;
  }
  EXPECT_LT(std::abs(noisy.Z("lidar p2p east, mean square")), 4.0);
}

TEST(Locations, NoiseOfPairsShowsInPairs) {
  const ComparedReplicates noisy("effects: [{effect: p2p_noise_scale, value: 1.5}]");
  EXPECT_LE(noisy.test.p_value, 0.03);
  EXPECT_GT(noisy.Z("lidar p2p east, mean square"), 5.0);
  EXPECT_LT(std::abs(noisy.Z("gnss position east, mean square")), 4.0);
}

TEST(Locations, PredictionErrorsAreInMetres) {
  const ComparedReplicates without("");
  // sigma_p is 3 cm, that of GNSS 1.5 cm; a prediction adds its own error.
  EXPECT_GT(without.appearance.pair_rms_m, 0.029);
  EXPECT_LT(without.appearance.pair_rms_m, 0.04);
  EXPECT_GT(without.appearance.gnss_rms_m, 0.015);
  EXPECT_LT(without.appearance.gnss_rms_m, 0.04);
}

}  // namespace dn::diagnosis_internal
