#include <dn/error.h>
#include <dn/imu/allan.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "testing/expect_invalid.h"

namespace dn::imu_test {

/// Draws noise with known terms exactly: white noise of density N, Gauss-Markov (s, T), random walk
/// K.
std::vector<double> Draw(unsigned seed, std::size_t n, double dt_s, double white, double gm_sigma,
                         double gm_tau_s, double walk) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const double decay = gm_tau_s > 0.0 ? std::exp(-dt_s / gm_tau_s) : 0.0;
  double gm = normal(rng), rw = 0.0;
  std::vector<double> x(n);
  for (double& value : x) {
    gm = decay * gm + std::sqrt(1.0 - decay * decay) * normal(rng);
    rw += walk * std::sqrt(dt_s) * normal(rng);
    value = white / std::sqrt(dt_s) * normal(rng) + gm_sigma * gm + rw;
  }
  return x;
}

constexpr double kDt_s = 0.01;
constexpr std::size_t kHour = 360000;

TEST(AllanVariance, AgreesWithHandComputation) {
  // The angles theta are 0, 1, 0, 1, ...: every second difference is +-2 at m = 1 and 0 at m = 2.
  std::vector<double> rates;
  for (int k = 0; k < 200; ++k) rates.push_back(k % 2 == 0 ? 1.0 : -1.0);
  const std::vector<AllanPoint> curve = AllanVariance(rates, 1.0);
  EXPECT_NEAR(curve[0].variance, 2.0, 1e-12);
  EXPECT_NEAR(curve[1].variance, 0.0, 1e-12);
  EXPECT_EQ(curve.back().tau_s, 32.0);
}

TEST(AllanVariance, WhiteNoiseFallsWithTheClusterTime) {
  const std::vector<AllanPoint> curve =
      AllanVariance(Draw(1, kHour, kDt_s, 0.02, 0.0, 0.0, 0.0), kDt_s);
  for (const AllanPoint& p : curve) {
    const double expected = 0.02 / std::sqrt(p.tau_s);
    EXPECT_NEAR(p.deviation() / expected, 1.0, 4.0 / std::sqrt(2.0 * p.dof)) << p.tau_s;
  }
}

// The squared scatter of many estimates gives their degrees of freedom.
TEST(AllanVariance, DegreesOfFreedomMatchTheScatter) {
  constexpr int kSeeds = 400;
  constexpr std::size_t kPoint = 6;
  double sum = 0.0, sum2 = 0.0, dof = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const AllanPoint p = AllanVariance(Draw(seed, 1000, 1.0, 1.0, 0.0, 0.0, 0.0), 1.0)[kPoint];
    sum += p.variance / kSeeds;
    sum2 += p.variance * p.variance / kSeeds;
    dof = p.dof;
  }
  EXPECT_NEAR(2.0 * sum * sum / (sum2 - sum * sum) / dof, 1.0, 0.3);
}

TEST(AllanVariance, GaussMarkovProcessPeaksAtTheKnownClusterTime) {
  constexpr double kT_s = 100.0;
  double peak = 0.0, at = 0.0;
  for (double tau_s = 1.0; tau_s < 1e4; tau_s *= 1.01) {
    const double v = GaussMarkovAllanVariance(tau_s, kT_s);
    if (v > peak) {
      peak = v;
      at = tau_s;
    }
  }
  EXPECT_NEAR(std::sqrt(peak), 0.618, 1e-3);
  EXPECT_NEAR(at / kT_s, 1.89, 0.02);
  EXPECT_NEAR(GaussMarkovAllanVariance(0.0999, kT_s) / GaussMarkovAllanVariance(0.1001, kT_s),
              0.0999 / 0.1001, 1e-5)
      << "the series joins";
}

TEST(FitNoise, WhiteAloneStaysAlone) {
  int false_alarms = 0;
  constexpr int kSeeds = 60;
  double sum = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const NoiseFit fit =
        FitNoise(AllanVariance(Draw(seed, 60000, kDt_s, 0.02, 0.0, 0.0, 0.0), kDt_s));
    ASSERT_TRUE(fit.white);
    sum += fit.white->value / kSeeds;
    EXPECT_NEAR(fit.white->value, 0.02, 5.0 * fit.white->sigma);
    false_alarms += fit.gauss_markov || fit.random_walk ? 1 : 0;
  }
  EXPECT_NEAR(sum, 0.02, 1e-4);
  EXPECT_LE(false_alarms, 2) << "two terms, one in a thousand each, and points that correlate";
}

TEST(FitNoise, RecoversWhiteAndGaussMarkov) {
  double tau = 0.0, sigma = 0.0;
  constexpr int kSeeds = 8;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const NoiseFit fit =
        FitNoise(AllanVariance(Draw(seed, 2 * kHour, kDt_s, 0.01, 0.02, 30.0, 0.0), kDt_s));
    ASSERT_TRUE(fit.white && fit.gauss_markov && fit.gauss_markov_tau_s) << seed;
    EXPECT_FALSE(fit.random_walk) << seed;
    EXPECT_NEAR(fit.white->value, 0.01, 5.0 * fit.white->sigma);
    tau += std::log(fit.gauss_markov_tau_s->value / 30.0) / kSeeds;
    sigma += std::log(fit.gauss_markov->value / 0.02) / kSeeds;
  }
  // A record of 7200 s contains about a hundred independent values, so that the errors are 7 % for
  // sigma and 15 % for tau. The errors of the means over all seeds are smaller.
  EXPECT_NEAR(sigma, 0.0, 0.1);
  EXPECT_NEAR(tau, 0.0, 0.2);
}

TEST(FitNoise, RecoversWhiteAndRandomWalk) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const NoiseFit fit =
        FitNoise(AllanVariance(Draw(seed, kHour, kDt_s, 0.01, 0.0, 0.0, 0.001), kDt_s));
    ASSERT_TRUE(fit.white);
    ASSERT_TRUE(fit.random_walk || fit.gauss_markov) << "a slow process";
    if (fit.random_walk) {
      EXPECT_NEAR(std::log(fit.random_walk->value / 0.001), 0.0, 0.4);
    }
    EXPECT_NEAR(std::sqrt(fit.Variance(500.0) / (1e-6 * 500.0 / 3.0)), 1.0, 0.5);
  }
}

// A coarse file resolution and a filter change the noise over a few samples, but not its terms.
TEST(FitNoise, IsNotMisledByResolutionAndFilter) {
  std::vector<double> x = Draw(3, kHour, kDt_s, 0.01, 0.0, 0.0, 0.0);
  double filtered = 0.0;
  for (double& value : x) {
    filtered += 0.5 * (value - filtered);
    value = 0.1 * std::floor(filtered / 0.1 + 0.5);
  }
  const NoiseFit fit = FitNoise(AllanVariance(x, kDt_s));
  ASSERT_TRUE(fit.white);
  EXPECT_NEAR(fit.white->value / 0.01, 1.0, 0.15);
  EXPECT_FALSE(fit.random_walk);
}

TEST(FitNoise, BecomesAModelOfATriad) {
  const NoiseFit fit =
      FitNoise(AllanVariance(Draw(2, 2 * kHour, kDt_s, 0.01, 0.02, 30.0, 0.0), kDt_s));
  const SensorNoise noise = fit.ToSensorNoise();
  EXPECT_EQ(noise.white, fit.white->value);
  ASSERT_EQ(noise.processes.size(), 1U);
  EXPECT_EQ(noise.processes[0].type, BiasProcess::Type::kGaussMarkov);
  EXPECT_EQ(noise.processes[0].tau_s, fit.gauss_markov_tau_s->value);
}

TEST(MeanCurve, ThreeAxesAddTheirDegreesOfFreedom) {
  std::vector<std::vector<AllanPoint>> curves;
  for (unsigned axis = 1; axis <= 3; ++axis) {
    curves.push_back(AllanVariance(Draw(axis, 20000, kDt_s, 0.02, 0.0, 0.0, 0.0), kDt_s));
  }
  const std::vector<AllanPoint> mean = MeanCurve(curves);
  EXPECT_NEAR(mean[0].dof / curves[0][0].dof, 3.0, 0.01);
  EXPECT_NEAR(mean[3].variance,
              (curves[0][3].variance + curves[1][3].variance + curves[2][3].variance) / 3.0, 1e-15);
}

TEST(AllanVariance, RejectsBadInput) {
  testing::ExpectInvalid([] { AllanVariance(std::vector<double>(50, 1.0), 1.0); }, "too few", 0);
  testing::ExpectInvalid([] { AllanVariance(std::vector<double>(500, 1.0), 0.0); }, "positive", 0);
  std::vector<double> x(500, 1.0);
  x[7] = std::numeric_limits<double>::quiet_NaN();
  testing::ExpectInvalid([&] { AllanVariance(x, 1.0); }, "not finite", 0);
  testing::ExpectInvalid([] { FitNoise({{1.0, 1.0, 10.0}}); }, "too short", 0);
}

}  // namespace dn::imu_test
