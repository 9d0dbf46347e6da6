#include "time_constant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dn::diagnosis_internal {

constexpr double kTau_s = 30.0, kSize = 2.0;

/// Returns a log likelihood that falls on both sides of ln(30 s) like two normal distributions. The
/// size varies with a power of the time constant.
SizesByTau TwoSided(double sigma_shorter, double sigma_longer, double power = 0.0) {
  return [=](double tau_s) -> std::optional<LikelySize> {
    const double off = std::log(tau_s / kTau_s);
    const double z = off / (off > 0.0 ? sigma_longer : sigma_shorter);
    return LikelySize{kSize * std::exp(power * off), 0.1, 50.0 - 0.5 * z * z};
  };
}

/// Returns the upper end of the 95 % interval of the logarithm, relative to the value.
double Upper(double value, double sigma) { return std::log1p(1.96 * sigma / value); }

TEST(LikeliestProcess, OfANormalLikelihoodHasItsPeakAndInterval) {
  for (const double start_s : {12.0, 30.0, 100.0}) {
    const auto process = LikeliestProcess(TwoSided(0.4, 0.4), start_s);
    ASSERT_TRUE(process) << start_s;
    EXPECT_NEAR(process->tau_s, kTau_s, 1e-9 * kTau_s);
    EXPECT_NEAR(Upper(process->tau_s, process->tau_sigma_s), 1.96 * 0.4, 1e-9);
    EXPECT_NEAR(process->size, kSize, 1e-9);
    EXPECT_NEAR(Upper(process->size, process->size_sigma), 1.96 * 0.1, 1e-9);
  }
}

TEST(LikeliestProcess, ReachesAsFarAsItsLongerSide) {
  const auto upwards = LikeliestProcess(TwoSided(0.3, 0.8), kTau_s);
  ASSERT_TRUE(upwards);
  EXPECT_NEAR(Upper(upwards->tau_s, upwards->tau_sigma_s) + std::log(upwards->tau_s / kTau_s),
              1.96 * 0.8, 0.1);
  const auto downwards = LikeliestProcess(TwoSided(0.8, 0.5), kTau_s);
  ASSERT_TRUE(downwards);
  EXPECT_LE(downwards->tau_s - 1.96 * downwards->tau_sigma_s, kTau_s * std::exp(-1.96 * 0.8));
}

TEST(LikeliestProcess, SizeIsAsUncertainAsTheTimeItGoesWith) {
  const auto process = LikeliestProcess(TwoSided(0.4, 0.4, 0.5), kTau_s);
  ASSERT_TRUE(process);
  EXPECT_NEAR(Upper(process->size, process->size_sigma), 1.96 * std::hypot(0.1, 0.5 * 0.4), 1e-9);
}

TEST(LikeliestProcess, EndsWhereItWasTriedWhenTheLikelihoodHardlyFalls) {
  const auto process = LikeliestProcess(TwoSided(0.3, 50.0), kTau_s);
  ASSERT_TRUE(process);
  EXPECT_NEAR(Upper(process->tau_s, process->tau_sigma_s) + std::log(process->tau_s / kTau_s),
              4.0 * std::log(1.6), 1e-6);
}

TEST(LikeliestProcess, WithoutAMaximumHasNoTime) {
  const auto process = LikeliestProcess(
      [](double tau_s) {
        return LikelySize{std::sqrt(tau_s), 0.1, std::log(tau_s)};
      },
      kTau_s);
  ASSERT_TRUE(process);
  EXPECT_TRUE(std::isnan(process->tau_sigma_s));
  EXPECT_GT(process->size_sigma, process->size);
}

TEST(LikeliestProcess, NeedsNetworksBesideItsStart) {
  const auto only_the_start = [](double tau_s) -> std::optional<LikelySize> {
    if (std::abs(tau_s - kTau_s) > 1e-9) return std::nullopt;
    return LikelySize{};
  };
  EXPECT_FALSE(LikeliestProcess(only_the_start, kTau_s));
}

}  // namespace dn::diagnosis_internal
