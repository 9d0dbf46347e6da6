#include <dn/diagnosis/diagnose.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

GapResult DiagnoseQuickly(const Flight& flight) {
  GapOptions options;
  options.depth = GapOptions::Depth::kQuick;
  options.threads = 2;
  return Diagnose(flight, options);
}

/// Returns a flight whose pairs have nearly no noise.
SimulatedFlight FlyWithoutPairNoise() {
  Scenario scenario =
      testing::AircraftScenario("effects: [{effect: p2p_noise_scale, value: 0.01}]\n");
  scenario.pairs.count = 1500;
  return testing::Fly(scenario, 5);
}

TEST(HeavyTailsManyRuns, AreNeitherOutliersNorLargerNoise) {
  SimulatedFlight sim = FlyWithoutPairNoise();
  std::mt19937_64 random(3);
  std::student_t_distribution<double> student(4.0);
  for (LidarPair& pair : sim.flight.pairs->pairs) {
    for (double& u : pair.u_i_s) u += sim.flight.config.lidar->sigma_p_m * student(random);
  }
  const GapResult result = DiagnoseQuickly(sim.flight);
  const GapVerdict& verdict = result.diagnosis.verdict;
  EXPECT_TRUE(verdict.unknown);
  EXPECT_THAT(verdict.effects, IsEmpty());
  ASSERT_EQ(verdict.heavy_tails.size(), 1U) << verdict.text;
  EXPECT_EQ(verdict.heavy_tails[0].sensor, "lidar");
  EXPECT_NEAR(verdict.heavy_tails[0].dof, 4.0, 1.0);
  EXPECT_THAT(verdict.text, ::testing::HasSubstr("lidar.robust: cauchy"));
  for (const GapCause& cause : result.diagnosis.causes) EXPECT_LT(cause.posterior, 0.5);
  EXPECT_EQ(result.adapted.lidar->robust, RobustKind::kCauchy);
  EXPECT_TRUE(result.adapted.unexplained.empty());
}

TEST(HeavyTailsManyRuns, OutliersAreNot) {
  Scenario scenario =
      testing::AircraftScenario("effects: [{effect: p2p_outliers, value: [0.03, 1]}]\n");
  scenario.pairs.count = 1500;
  const SimulatedFlight sim = testing::Fly(scenario, 5);
  const GapResult result = DiagnoseQuickly(sim.flight);
  EXPECT_THAT(result.diagnosis.verdict.effects, ElementsAre("p2p_outliers"));
  EXPECT_THAT(result.diagnosis.verdict.heavy_tails, IsEmpty());
}

}  // namespace dn::diagnosis_test
