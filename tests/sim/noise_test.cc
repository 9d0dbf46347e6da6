#include <dn/error.h>
#include <dn/sim/error_process.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/small_scenario.h"

namespace dn::sim_test {

using Eigen::Vector3d;

BiasProcess GaussMarkov(double sigma, double tau_s) {
  return {BiasProcess::Type::kGaussMarkov, sigma, tau_s};
}

TEST(IntervalCovariance, AgreesWithFineStepsOfTheProcess) {
  // The reference is the exact discrete process with a step a thousand times shorter, averaged over
  // the interval.
  constexpr double kSigma = 2.0, kTau_s = 3.0, kDt_s = 1.5;
  constexpr int kSub = 1000;
  const double phi = std::exp(-kDt_s / kSub / kTau_s);
  const double q = kSigma * kSigma * (1.0 - phi * phi);
  // x_n = sum phi^(n-k) w_k, mean = sum_k w_k (1 - phi^(n-k+1)) / (1 - phi) / n
  Eigen::Matrix2d C = Eigen::Matrix2d::Zero();
  for (int k = 1; k <= kSub; ++k) {
    const double end = std::pow(phi, kSub - k);
    const double mean = (1.0 - std::pow(phi, kSub - k + 0.5)) / (1.0 - phi) / kSub;
    C += q * Eigen::Vector2d(end, mean) * Eigen::RowVector2d(end, mean);
  }
  const Eigen::Matrix2d exact = IntervalCovariance(GaussMarkov(kSigma, kTau_s), kDt_s);
  EXPECT_LT((C - exact).cwiseAbs().maxCoeff(), 2e-3 * exact.maxCoeff());  // O(1 / kSub)
}

TEST(IntervalCovariance, LongCorrelationIsARandomWalk) {
  // For sigma^2 = q tau / 2 and tau to infinity, the covariance is that of the random walk.
  constexpr double kTau_s = 1e9, kDensity = 0.3, kDt_s = 0.005;
  const double sigma = kDensity * std::sqrt(kTau_s / 2.0);
  const Eigen::Matrix2d markov = IntervalCovariance(GaussMarkov(sigma, kTau_s), kDt_s);
  const Eigen::Matrix2d walk =
      IntervalCovariance({BiasProcess::Type::kRandomWalk, kDensity, 0.0}, kDt_s);
  EXPECT_LT((markov - walk).cwiseAbs().maxCoeff(), 1e-9 * walk.maxCoeff());
  EXPECT_THROW(IntervalCovariance(GaussMarkov(1.0, 1.0), 0.0), InvalidInput);
}

TEST(ErrorProcess, GaussMarkovIsStationaryWithItsCorrelation) {
  constexpr double kSigma = 3.0, kTau_s = 0.8, kDt_s = 0.1;
  constexpr int kSteps = 400000;  // 50000 correlation times: the variance is known to 1 %
  constexpr int kLag = 5;
  Random random(11, "test");
  ErrorProcess process(GaussMarkov(kSigma, kTau_s), kDt_s, random);
  std::vector<double> end, mean;
  for (int i = 0; i < kSteps; ++i) {
    mean.push_back(process.NextMean(random));
    end.push_back(process.value());
  }
  const auto covariance = [](const std::vector<double>& x, int lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < x.size(); ++i) sum += x[i] * x[i + lag];
    return sum / static_cast<double>(x.size() - lag);
  };
  const double a = kDt_s / kTau_s;
  const double variance = kSigma * kSigma;
  EXPECT_NEAR(covariance(end, 0), variance, 0.03 * variance);
  EXPECT_NEAR(covariance(end, kLag), variance * std::exp(-kLag * a), 0.03 * variance);
  // The mean over an interval has variance 2 sigma^2 (a - 1 + exp(-a)) / a^2.
  const double of_mean = 2.0 * variance * (a - 1.0 + std::exp(-a)) / (a * a);
  EXPECT_NEAR(covariance(mean, 0), of_mean, 0.03 * variance);
  // Means that are lag intervals apart have covariance sigma^2 exp(-(lag - 1) a) ((1 - exp(-a)) /
  // a)^2.
  const double loss = (1.0 - std::exp(-a)) / a;
  EXPECT_NEAR(covariance(mean, kLag), variance * std::exp(-(kLag - 1) * a) * loss * loss,
              0.03 * variance);
}

TEST(ErrorProcess, StartsStationary) {
  constexpr int kDraws = 20000;
  constexpr double kSigma = 2.0;
  double squared = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    Random random(static_cast<std::uint64_t>(i), "start");
    ErrorProcess process(GaussMarkov(kSigma, 3600.0), 0.005, random);
    const double mean = process.NextMean(random);
    squared += mean * mean;
  }
  EXPECT_NEAR(squared / kDraws, kSigma * kSigma, 0.05 * kSigma * kSigma);  // 5 sigma are 5 %
}

TEST(ErrorProcess, RandomWalkGrowsWithTimeAndConstantStays) {
  constexpr double kDensity = 0.7, kDt_s = 0.02;
  constexpr int kDraws = 4000, kSteps = 100;
  double squared = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    Random random(static_cast<std::uint64_t>(i), "walk");
    ErrorProcess walk({BiasProcess::Type::kRandomWalk, kDensity, 0.0}, kDt_s, random);
    for (int k = 0; k < kSteps; ++k) walk.NextMean(random);
    squared += walk.value() * walk.value();
  }
  const double variance = kDensity * kDensity * kDt_s * kSteps;
  EXPECT_NEAR(squared / kDraws, variance, 0.1 * variance);  // 4.5 sigma

  Random random(5, "constant");
  ErrorProcess constant({BiasProcess::Type::kRandomConstant, 1.0, 0.0}, kDt_s, random);
  const double first = constant.NextMean(random);
  EXPECT_NE(first, 0.0);
  for (int k = 0; k < kSteps; ++k) EXPECT_EQ(constant.NextMean(random), first);
}

TEST(SimulatedImu, ErrorsAreBiasPlusWhiteNoiseOfTheModel) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 0;
  const SimulatedFlight noisy = Simulate(scenario, {.seed = 4});
  const SimulatedFlight clean = Simulate(scenario, {.seed = 4, .noise = false});
  const auto& a = noisy.flight.imu->samples;
  const auto& b = clean.flight.imu->samples;
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.size(), noisy.gyro_bias_radps.size());
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(clean.gyro_bias_radps[i].norm(), 0.0);
    gyro += (a[i].w_ib_b_radps - b[i].w_ib_b_radps - noisy.gyro_bias_radps[i]).cwiseAbs2();
    accel += (a[i].f_b_mps2 - b[i].f_b_mps2 - noisy.accel_bias_mps2[i]).cwiseAbs2();
  }
  const auto n = static_cast<double>(a.size());
  const double dt_s = 1.0 / scenario.imu.rate_hz;
  const double gyro_variance = std::pow(scenario.imu.model.gyro.white, 2) / dt_s;
  const double accel_variance = std::pow(scenario.imu.model.accel.white, 2) / dt_s;
  const double tolerance = 5.0 * std::sqrt(2.0 / n);  // 5 sigma of a sample variance
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(gyro[axis] / n / gyro_variance, 1.0, tolerance);
    EXPECT_NEAR(accel[axis] / n / accel_variance, 1.0, tolerance);
  }
  EXPECT_GT(noisy.gyro_bias_radps.front().norm(), 0.0);
  EXPECT_NE(noisy.gyro_bias_radps.front(), noisy.gyro_bias_radps.back());
}

TEST(SimulatedImu, SamplesAreMeansOverTheirIntervals) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 0;
  const SimulatedFlight clean = Simulate(scenario, {.noise = false});
  constexpr int kSub = 200;
  for (std::size_t i = 100; i < clean.flight.imu->samples.size(); i += 997) {
    const ImuSample& sample = clean.flight.imu->samples[i];
    Vector3d w = Vector3d::Zero(), f = Vector3d::Zero();
    for (int k = 0; k < kSub; ++k) {
      const double t_s = sample.t_s - sample.dt_s + (k + 0.5) * sample.dt_s / kSub;
      w += clean.truth->AngularRate(t_s) / kSub;
      f += clean.truth->SpecificForce(t_s) / kSub;
    }
    EXPECT_LT((w - sample.w_ib_b_radps).norm(), 1e-7);  // error of the midpoint rule
    EXPECT_LT((f - sample.f_b_mps2).norm(), 1e-6);
  }
}

}  // namespace dn::sim_test
