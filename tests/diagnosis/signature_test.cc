#include <dn/diagnosis/signature.h>
#include <dn/error.h>
#include <gtest/gtest.h>

#include <cmath>

#include "screen.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using testing::AircraftScenario;

Flight Perfect(const std::string& effects) {
  SimulateOptions options;
  options.noise = false;
  return Simulate(AircraftScenario(effects), options).flight;
}

Signature EffectSignature(const std::string& effect, const GapOptions& options = {}) {
  return ComputeSignature(Perfect("effects: [" + effect + "]"), Perfect(""), options);
}

TEST(Signature, AnEffectOfTheTableLeavesNothing) {
  const Signature arm = EffectSignature("{effect: gnss_lever_arm, value: [0.1, 0, 0]}");
  EXPECT_EQ(arm.nearest, "gnss_lever_arm");
  EXPECT_GT(arm.lambda, 30.0);
  EXPECT_LT(arm.lambda_left, 0.01 * arm.lambda);
}

TEST(Signature, GrowsWithTheSquareOfTheSize) {
  const Signature once = EffectSignature("{effect: lidar_range_offset, value: [0.05]}");
  const Signature twice = EffectSignature("{effect: lidar_range_offset, value: [0.1]}");
  EXPECT_NEAR(twice.lambda, 4.0 * once.lambda, 0.02 * twice.lambda);
}

TEST(Signature, WhatTheLibraryLacksIsLeftButForWhatItsRelativesTake) {
  GapOptions options;
  options.left_out = {"lidar_range_offset"};
  const std::string effect = "{effect: lidar_range_offset, value: [0.1]}";
  const Signature whole = EffectSignature(effect), left_out = EffectSignature(effect, options);
  EXPECT_NEAR(left_out.lambda, whole.lambda, 1e-6 * whole.lambda);
  EXPECT_NE(left_out.nearest, "lidar_range_offset");
  EXPECT_GT(left_out.lambda_left, whole.lambda_left);
  EXPECT_LT(left_out.lambda_left, left_out.lambda);
}

TEST(Signature, OfNothingIsNone) {
  EXPECT_LT(ComputeSignature(Perfect(""), Perfect("")).lambda, 1e-9);
}

// The best test is that of the effect itself. In data with noise its statistic has the mean lambda
// + 1 and the standard deviation sqrt(2 + 4 lambda).
TEST(Signature, IsWhatATestSeesInNoise) {
  const std::string effect = "effects: [{effect: lidar_range_offset, value: [0.05]}]";
  const double lambda = ComputeSignature(Perfect(effect), Perfect("")).lambda;
  constexpr int kSeeds = 6;
  double mean = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SimulateOptions options;
    options.seed = seed;
    const Flight flight = Simulate(AircraftScenario(effect), options).flight;
    const Adjustment adjustment = Adjust(flight);
    const Marginals marginals(adjustment.network->net());
    const diagnosis_internal::Screen screen(*adjustment.network, marginals,
                                            {{"lidar_range_offset"}, {}, 1});
    mean += screen.Effects().front().statistic / kSeeds;
  }
  EXPECT_NEAR(mean, lambda + 1.0, 3.5 * std::sqrt((2.0 + 4.0 * lambda) / kSeeds) + 0.1 * lambda);
}

}  // namespace dn::diagnosis_test
