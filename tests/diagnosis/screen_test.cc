#include "screen.h"

#include <dn/effects/effect_table.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>

#include "network_fit.h"
#include "processes.h"
#include "refine_times.h"
#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::diagnosis_internal {

using testing::AircraftScenario;
using testing::kSigmas;

/// A fixed effect of a size that the flight shows, but that is still of first order.
struct Shown {
  std::string effect;
  std::vector<double> value;
  std::string times = "";
};

void PrintTo(const Shown& shown, std::ostream* out) { *out << shown.effect; }

std::string Entry(const Shown& shown) {
  std::string text = "effects: [{effect: " + shown.effect + ", value: [";
  for (std::size_t k = 0; k < shown.value.size(); ++k) {
    text += (k == 0 ? "" : ", ") + std::to_string(shown.value[k]);
  }
  return text + "]" + shown.times + "}]";
}

class FixedEffect : public ::testing::TestWithParam<Shown> {};

TEST_P(FixedEffect, IsEstimatedAndExplainsTheDataBest) {
  const Shown& shown = GetParam();
  const Flight flight = Simulate(AircraftScenario(Entry(shown)), {}).flight;
  GapOptions options;
  const NetworkFitter fitter(flight, options);
  NetworkFit fit = fitter.Fit({});
  const auto found =
      std::find_if(fit.effects.begin(), fit.effects.end(),
                   [&](const HypothesisEvidence& effect) { return effect.name == shown.effect; });
  ASSERT_NE(found, fit.effects.end());
  RefineTimes(fit.solution->network(), fit.solution->marginals(), 1, &*found);
  const GapCause cause = ToCause(*found);
  constexpr double kFirstOrder = 0.05;
  double most = 0.0;
  for (const double value : shown.value) most = std::max(most, std::abs(value));
  for (std::size_t k = 0; k < shown.value.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    EXPECT_NEAR(cause.estimate[at], shown.value[k], kSigmas * cause.sigma[at] + kFirstOrder * most)
        << "component " << k << ", sigma " << cause.sigma[at];
  }
  EXPECT_GT(found->log_evidence, 8.0);
  // An effect with a similar signature may explain a sample better, and so may second-order terms.
  constexpr double kAsGoodNats = 3.0, kSecondOrder = 0.05;
  const HypothesisEvidence& best = fit.effects.front();
  EXPECT_GE(found->log_evidence,
            best.log_evidence - std::max(kAsGoodNats, kSecondOrder * best.log_evidence))
      << best.name;
}

INSTANTIATE_TEST_SUITE_P(
    Screen, FixedEffect,
    ::testing::Values(
        Shown{"gnss_lever_arm", {0.05, 0.03, -0.05}}, Shown{"gnss_time_offset", {0.002}},
        Shown{"gnss_position_step", {0.06, -0.04, 0.08}, ", window_s: [381150, 381210]"},
        Shown{"gyro_scale_factor", {300, -300, 300}},
        Shown{"accel_scale_factor", {3000, 3000, 1000}}, Shown{"gyro_misalignment", {1, -1, 1}},
        Shown{"accel_misalignment", {1, -1, 1}}, Shown{"gyro_g_sensitivity", {10, -10, 10}},
        Shown{"gravity_tilt", {60, -60}}, Shown{"gravity_disturbance", {200}},
        Shown{"lidar_lever_arm", {0.1, 0.1, -0.2}}, Shown{"lidar_time_offset", {0.004}},
        Shown{"lidar_time_drift", {40}}, Shown{"lidar_range_offset", {0.1}},
        Shown{"lidar_range_scale", {800}}, Shown{"lidar_angle_scale", {800}},
        Shown{"lidar_scan_cone", {0.2}}, Shown{"lidar_scan_torsion", {0.05}},
        Shown{"boresight_drift", {0.5, -0.5, 0.5}},
        Shown{"boresight_step", {0.03, 0.03, -0.05}, ", t0_s: 381180"}),
    [](const auto& shown) { return shown.param.effect; });

TEST(Screen, FindsNothingInNoise) {
  const Flight flight = Simulate(AircraftScenario(), {}).flight;
  const GapOptions options;
  const NetworkFit fit = NetworkFitter(flight, options).Fit({});
  EXPECT_LT(fit.effects.front().log_evidence, 6.0) << fit.effects.front().name;
}

Flight FlightWithGnssStep(const std::string& window_s) {
  return Simulate(AircraftScenario("effects: [{effect: gnss_position_step, value: [0.3, 0.2, 0.3], "
                                   "window_s: " +
                                   window_s + "}]"),
                  {})
      .flight;
}

TEST(RefineTimes, FindsTheEndsOfAWindow) {
  const Flight flight = FlightWithGnssStep("[381131, 381177]");
  const GapOptions options;
  const NetworkFit fit = NetworkFitter(flight, options).Fit({});
  const HypothesisEvidence& best = fit.effects.front();
  ASSERT_EQ(best.name, "gnss_position_step");
  HypothesisEvidence refined = best;
  RefineTimes(fit.solution->network(), fit.solution->marginals(), 1, &refined);
  ASSERT_TRUE(refined.times.window_s.has_value());
  constexpr double kEpochS = 1.0;
  EXPECT_NEAR(refined.times.window_s->first, 381131.0, kEpochS);
  EXPECT_NEAR(refined.times.window_s->second, 381177.0, kEpochS);
  for (Eigen::Index k = 0; k < 3; ++k) {
    EXPECT_NEAR(refined.estimate[k], k == 1 ? 0.2 : 0.3, 4.0 * refined.sigma[k]);
  }
}

TEST(RefineTimes, AStepLastsForFourEpochsAtLeast) {
  const Flight flight = FlightWithGnssStep("[381151, 381153]");
  const GapOptions options;
  const NetworkFit fit = NetworkFitter(flight, options).Fit({});
  const auto found = std::find_if(
      fit.effects.begin(), fit.effects.end(),
      [](const HypothesisEvidence& effect) { return effect.name == "gnss_position_step"; });
  ASSERT_NE(found, fit.effects.end());
  HypothesisEvidence refined = *found;
  RefineTimes(fit.solution->network(), fit.solution->marginals(), 1, &refined);
  constexpr double kEpochS = 1.0;
  EXPECT_GE(refined.times.window_s->second - refined.times.window_s->first, 3.0 * kEpochS);
}

TEST(RefineTimes, LeavesOtherEffectsAlone) {
  const Flight flight = Simulate(AircraftScenario(), {}).flight;
  const GapOptions options;
  const NetworkFit fit = NetworkFitter(flight, options).Fit({});
  for (const HypothesisEvidence& effect : fit.effects) {
    if (effect.name != "lidar_range_offset") continue;
    HypothesisEvidence refined = effect;
    RefineTimes(fit.solution->network(), fit.solution->marginals(), 1, &refined);
    EXPECT_EQ(refined.estimate, effect.estimate);
    EXPECT_EQ(refined.log_evidence, effect.log_evidence);
  }
}

HypothesisEvidence Judged(const std::string& effects, std::uint64_t seed = 1) {
  SimulateOptions options;
  options.seed = seed;
  const Flight flight = Simulate(AircraftScenario(effects), options).flight;
  HypothesisEvidence effect;
  effect.name = "gnss_correlated_noise";
  effect.estimate = effect.sigma = Eigen::VectorXd::Zero(4);
  const Adjustment adjustment = Adjust(flight);
  EvaluateProcess(*adjustment.network, 1, &effect);
  if (effect.log_evidence > 10.0) RefineProcess(*adjustment.network, 1, &effect);
  return effect;
}

TEST(EvaluateProcess, FindsTheSizeOfAProcess) {
  const HypothesisEvidence found =
      Judged("effects: [{effect: gnss_correlated_noise, value: [0.04, 0.04, 0.04, 15]}]");
  EXPECT_GT(found.log_evidence, 20.0);
  EXPECT_NEAR(found.estimate[0], 0.04, 3.0 * found.sigma[0]);
  EXPECT_LT(found.sigma[0], 0.01);
  EXPECT_GE(found.estimate[3], 4.0);
  EXPECT_LE(found.estimate[3], 60.0);
  // A longer time constant implies a larger size, nearly in proportion to its root.
  ASSERT_TRUE(std::isfinite(found.sigma[3]));
  EXPECT_GT(found.sigma[0] / found.estimate[0], 0.25 * found.sigma[3] / found.estimate[3]);
}

TEST(EvaluateProcess, SizesAndTimesAreWithinTheirSigmas) {
  constexpr int kSeeds = 8;
  double sigma2 = 0.0, tau2 = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const HypothesisEvidence found =
        Judged("effects: [{effect: gnss_correlated_noise, value: [0.1, 0.1, 0.1, 30]}]", seed);
    ASSERT_TRUE(std::isfinite(found.sigma[3])) << seed;
    // The likelihood is nearly normal in the logarithms; sigmas are those of the longer side.
    const double relative = std::log1p(1.96 * found.sigma[0] / found.estimate[0]) / 1.96;
    const double relative_tau = std::log1p(1.96 * found.sigma[3] / found.estimate[3]) / 1.96;
    sigma2 += std::pow(std::log(found.estimate[0] / 0.1) / relative, 2) / kSeeds;
    tau2 += std::pow(std::log(found.estimate[3] / 30.0) / relative_tau, 2) / kSeeds;
  }
  for (const double mean : {sigma2, tau2}) {
    EXPECT_LT(mean, 2.3) << "99 % of a mean of eight squares";
    EXPECT_GT(mean, 0.1) << "the longer side is twice the shorter one";
  }
}

// In seven minutes, errors correlated over hours show no time constant. The estimated size depends
// on the estimated time constant, and is as uncertain.
TEST(EvaluateProcess, WhatOutlastsTheFlightHasNoSureSize) {
  const HypothesisEvidence found =
      Judged("effects: [{effect: gnss_correlated_noise, value: [0.5, 0.5, 0.5, 10000]}]");
  ASSERT_GT(found.log_evidence, 10.0);
  EXPECT_TRUE(std::isnan(found.sigma[3]));
  EXPECT_GT(found.sigma[0], 0.2 * found.estimate[0]);
  EXPECT_LT(std::abs(std::log(found.estimate[0] / 0.5)), 3.0 * found.sigma[0] / found.estimate[0]);
}

TEST(EvaluateProcess, FindsNoneInNoise) { EXPECT_LT(Judged("").log_evidence, 2.0); }

}  // namespace dn::diagnosis_internal
