#include <dn/imu/rest_check.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace dn::imu_test {

constexpr double kDtS = 0.1;
constexpr std::size_t kSecond = 10;
constexpr double kOffset = 5.0;

std::vector<double> Constant(std::size_t size) { return std::vector<double>(size, kOffset); }

TEST(RestCheck, ARecordMayHaveAnyMean) {
  EXPECT_DOUBLE_EQ(MeanRate(Constant(600)), kOffset);
  EXPECT_TRUE(AtRest(Constant(600), kDtS, 1e-9));
}

TEST(RestCheck, ASecondOfMotionIsNotRest) {
  std::vector<double> rates = Constant(600);
  for (std::size_t k = 20 * kSecond; k < 21 * kSecond; ++k) rates[k] += 1.0;
  EXPECT_FALSE(AtRest(rates, kDtS, 0.9));
  EXPECT_TRUE(AtRest(rates, kDtS, 1.1));
}

// Noise within one second does not count as motion, however large it is.
TEST(RestCheck, VibrationThatAveragesOutIsRest) {
  std::vector<double> rates = Constant(600);
  for (std::size_t k = 0; k < rates.size(); ++k) rates[k] += k % 2 == 0 ? 10.0 : -10.0;
  EXPECT_TRUE(AtRest(rates, kDtS, 0.1));
}

TEST(RestCheck, ChecksEveryValueBelowOneHertz) {
  std::vector<double> rates = Constant(60);
  rates[30] += 1.0;
  EXPECT_FALSE(AtRest(rates, 2.0, 0.5));
}

// For white noise N, a mean over T has variance N^2 / T.
TEST(RestCheck, DriftIsRelativeToTheFittedTerms) {
  std::vector<double> rates = Constant(900);
  for (std::size_t k = 600; k < 900; ++k) rates[k] += 0.3;
  NoiseFit fit;
  fit.white = NoiseTerm{0.5, 0.01};
  const double third_s = 300 * kDtS;
  const double sigmas = 0.3 / (std::sqrt(2.0) * 0.5 / std::sqrt(third_s));
  EXPECT_NEAR(DriftInSigmas(rates, kDtS, fit), sigmas, 1e-9 * sigmas);
  // The random walk may be this drift, so it explains nothing.
  fit.random_walk = NoiseTerm{1.0, 0.1};
  EXPECT_NEAR(DriftInSigmas(rates, kDtS, fit), sigmas, 1e-9 * sigmas);
  for (double& rate : rates) rate = -rate;
  EXPECT_NEAR(DriftInSigmas(rates, kDtS, fit), -sigmas, 1e-9 * sigmas);
}

TEST(RestCheck, WhiteNoiseDoesNotDrift) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(kOffset, 1.0);
  double sum2 = 0.0;
  constexpr int kRecords = 200;
  for (int i = 0; i < kRecords; ++i) {
    std::vector<double> rates(900);
    for (double& rate : rates) rate = normal(random);
    NoiseFit fit;
    fit.white = NoiseTerm{std::sqrt(kDtS), 0.0};
    const double drift = DriftInSigmas(rates, kDtS, fit);
    sum2 += drift * drift;
  }
  EXPECT_NEAR(sum2 / kRecords, 1.0, 0.3);  // three sigmas of the mean of a chi-square
}

}  // namespace dn::imu_test
