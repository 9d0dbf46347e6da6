#include <dn/distributions.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dn::core_test {

// Tolerance: printed tables of the chi-square distribution have three to five digits.
constexpr double kTable = 5e-4;

TEST(Distributions, ChiSquareQuantilesOfPrintedTables) {
  EXPECT_NEAR(ChiSquareQuantile(0.99, 1.0), 6.6349, kTable);
  EXPECT_NEAR(ChiSquareQuantile(0.95, 3.0), 7.8147, kTable);
  EXPECT_NEAR(ChiSquareQuantile(0.01, 3.0), 0.1148, kTable);
  EXPECT_NEAR(ChiSquareQuantile(0.995, 10.0), 25.1882, kTable);
  EXPECT_NEAR(ChiSquareQuantile(0.005, 100.0), 67.3276, kTable);
}

TEST(Distributions, QuantileInvertsTheCdfAtEverySize) {
  for (const double dof : {1.0, 2.0, 3.0, 30.0, 300.0, 3e4, 1e6, 1e8}) {
    for (const double p : {1e-4, 0.005, 0.3, 0.5, 0.9, 0.995}) {
      EXPECT_NEAR(ChiSquareCdf(ChiSquareQuantile(p, dof), dof), p, 1e-9) << dof;
    }
  }
  EXPECT_NEAR(ChiSquareCdf(1e5 + 499.9, 1e5 - 0.1), ChiSquareCdf(1e5 + 500.1, 1e5 + 0.1), 2e-6);
  // There is a closed form for two degrees of freedom.
  EXPECT_NEAR(ChiSquareCdf(1.7, 2.0), 1.0 - std::exp(-0.85), 1e-12);
  EXPECT_EQ(ChiSquareCdf(-1.0, 2.0), 0.0);
}

TEST(Distributions, IntervalOfTheMeanNarrowsAsTheRootOfItsNumber) {
  const Interval few = ChiSquareInterval(0.99, 48.0), many = ChiSquareInterval(0.99, 4800.0);
  EXPECT_TRUE(few.Contains(1.0));
  EXPECT_FALSE(many.Contains(few.low));
  EXPECT_NEAR((few.high - few.low) / (many.high - many.low), 10.0, 0.5);
}

TEST(Distributions, NormalQuantiles) {
  EXPECT_NEAR(NormalQuantile(0.5), 0.0, 1e-15);
  EXPECT_NEAR(NormalQuantile(0.975), 1.959964, 1e-6);
  EXPECT_NEAR(NormalQuantile(0.005), -2.575829, 1e-6);
}

// Ten trials of probability one half: P(k <= 1) = 11/1024, P(k <= 2) = 56/1024.
TEST(Distributions, BinomialIntervalByHand) {
  const Interval interval = BinomialInterval(0.95, 10, 0.5);
  EXPECT_NEAR(interval.low, 0.2, 1e-12);
  EXPECT_NEAR(interval.high, 0.8, 1e-12);
  const Interval rare = BinomialInterval(0.99, 300, 0.9973);
  EXPECT_EQ(rare.high, 1.0);
  EXPECT_LT(rare.low, 0.9973);
}

TEST(Distributions, UniformValuesPassAndOthersFail) {
  constexpr int kValues = 100;
  constexpr double kOfReference = 1e9;
  std::vector<double> even, squared;
  for (int k = 0; k < kValues; ++k) {
    even.push_back((k + 0.5) / kValues);
    squared.push_back(even.back() * even.back());
  }
  EXPECT_GT(UniformityPValue(even, kOfReference), 0.999);
  EXPECT_LT(UniformityPValue(squared, kOfReference), 1e-4);
  // Printed tables give p = 0.05 for a largest distance of 0.134 of 100 values.
  std::vector<double> shifted;
  for (const double value : even) shifted.push_back(std::min(1.0, value + 0.129));
  EXPECT_NEAR(UniformityPValue(shifted, kOfReference), 0.05, 0.01);
}

}  // namespace dn::core_test
