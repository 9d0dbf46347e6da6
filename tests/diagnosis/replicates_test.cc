#include "replicates.h"

#include <dn/axis_names.h>
#include <dn/distributions.h>
#include <dn/sim/random.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "network_fit.h"
#include "network_source.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using testing::DroneScenario;

constexpr Eigen::Index kPlaces = 20;
constexpr int kReplicates = 200;

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
  ReplicateSet replicates;
  for (int k = 0; k < kReplicates; ++k) replicates.all.push_back(Drawn(random));
  return replicates;
}

TEST(CompareWithReplicates, IsAsOftenSmallAsItSays) {
  constexpr long kFlights = 400;
  Random random(7, "flights without a gap");
  const ReplicateSet replicates = DrawReplicates(&random);
  long below_half = 0;
  for (long k = 0; k < kFlights; ++k) {
    if (CompareWithReplicates(Drawn(&random), replicates).p_value <= 0.5) ++below_half;
  }
  // All flights use the same 100 ranking replicates. Their own share below a half is random with a
  // standard deviation of 5 %.
  const Interval usual = BinomialInterval(0.9999, 80, 0.5);
  EXPECT_TRUE(usual.Contains(static_cast<double>(below_half) / kFlights)) << below_half;
}

TEST(CompareWithReplicates, IsRightOverManySetsOfReplicates) {
  constexpr long kFlights = 150;
  long small = 0;
  for (long k = 0; k < kFlights; ++k) {
    Random random(static_cast<std::uint64_t>(k), "flight and twins");
    const ReplicateSet replicates = DrawReplicates(&random);
    if (CompareWithReplicates(Drawn(&random), replicates).p_value <= 0.1) ++small;
  }
  const Interval usual = BinomialInterval(0.9999, kFlights, 0.1);
  EXPECT_TRUE(usual.Contains(static_cast<double>(small) / kFlights)) << small;
}

// A flight without a gap is one of n + 1 alike, so that small p-values are as rare as they say.
TEST(CompareWithReplicates, ManyRunsHaveTheStatedLevel) {
  constexpr long kFlights = 1500;
  constexpr std::array<double, 3> kLevels{0.01, 0.05, 0.2};
  std::array<long, 3> small{};
  for (long k = 0; k < kFlights; ++k) {
    Random random(static_cast<std::uint64_t>(k), "flight and replicates");
    const ReplicateSet replicates = DrawReplicates(&random);
    const double p = CompareWithReplicates(Drawn(&random), replicates).p_value;
    for (std::size_t at = 0; at < kLevels.size(); ++at) small[at] += p <= kLevels[at] ? 1 : 0;
  }
  for (std::size_t at = 0; at < kLevels.size(); ++at) {
    const Interval usual = BinomialInterval(0.999, kFlights, kLevels[at]);
    EXPECT_TRUE(usual.Contains(static_cast<double>(small[at]) / kFlights))
        << kLevels[at] << ": " << small[at];
  }
}

TEST(CompareWithReplicates, PValuesGoOnBeyondTheLastReplicate) {
  Random random(3, "a flight with a gap");
  const ReplicateSet replicates = DrawReplicates(&random);
  ResidualSummary flight = Drawn(&random);
  double before = 1.0 / 101.0;
  for (const double departure : {40.0, 80.0, 160.0}) {
    flight.locations[4] = departure;
    const double p = CompareWithReplicates(flight, replicates).p_value;
    EXPECT_LT(p, 0.01 * before) << departure;
    before = p;
  }
}

TEST(CompareWithReplicates, FindsThePlaceThatDeparts) {
  Random random(3, "a flight with a gap");
  const ReplicateSet replicates = DrawReplicates(&random);
  ResidualSummary flight = Drawn(&random);
  flight.locations[4] += 20.0;
  const ReplicateTest test = CompareWithReplicates(flight, replicates);
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
  const ReplicateSet replicates = DrawReplicates(&random);
  ResidualSummary flight = Drawn(&random);
  flight.log_evidence[1] = 40.0;
  const ReplicateTest test = CompareWithReplicates(flight, replicates);
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
  ReplicateSet replicates = DrawReplicates(&random);
  for (std::size_t k = 2 * replicates.all.size() / 3; k < replicates.all.size(); ++k) {
    replicates.all[k].locations[0] += 8.0;
  }
  EXPECT_LT(TestReplicateConsistency(replicates), 1e-4);
}

Comparison CompareDrone(const std::string& effects) {
  const Flight flight = Simulate(DroneScenario(effects), {}).flight;
  const GapOptions options;
  return CompareNetwork(NetworkFitter(flight, options).Fit({}), {.count = kReplicates});
}

double Z(const Comparison& compared, const std::string& name) {
  for (std::size_t k = 0; k < compared.statistics.size(); ++k) {
    if (StatisticName(compared.statistics[k]) == name) {
      return compared.test.z[static_cast<Eigen::Index>(k)];
    }
  }
  return std::nan("");
}

TEST(Locations, LinearReplicatesAreAlike) {
  const Comparison without = CompareDrone("");
  EXPECT_GT(TestReplicateConsistency(without.replicates), 1e-4);
  EXPECT_GT(without.test.p_value, 0.02);
  EXPECT_LT(std::abs(Z(without, "gnss position east, mean square")), 4.0);
}

TEST(Locations, NoiseOfGnssShowsInGnss) {
  const Comparison noisy = CompareDrone("effects: [{effect: gnss_noise_scale, value: 1.5}]");
  EXPECT_LE(noisy.test.p_value, 0.03);
  for (const char* axis : kEnu) {
    EXPECT_GT(Z(noisy, std::string("gnss position ") + axis + ", mean square"), 5.0) << axis;
  }
  EXPECT_LT(std::abs(Z(noisy, "lidar p2p east, mean square")), 4.0);
}

TEST(Locations, NoiseOfPairsShowsInPairs) {
  const Comparison noisy = CompareDrone("effects: [{effect: p2p_noise_scale, value: 1.5}]");
  EXPECT_LE(noisy.test.p_value, 0.03);
  EXPECT_GT(Z(noisy, "lidar p2p east, mean square"), 5.0);
  EXPECT_LT(std::abs(Z(noisy, "gnss position east, mean square")), 4.0);
}

TEST(Locations, PredictionErrorsAreInMetres) {
  const Comparison without = CompareDrone("");
  // sigma_p is 3 cm, that of GNSS 1.5 cm; a prediction adds its own error.
  EXPECT_GT(without.appearance.pair_rms_m, 0.029);
  EXPECT_LT(without.appearance.pair_rms_m, 0.04);
  EXPECT_GT(without.appearance.gnss_rms_m, 0.015);
  EXPECT_LT(without.appearance.gnss_rms_m, 0.04);
}

}  // namespace dn::diagnosis_internal
