#include "likelihood_peak.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace dn::diagnosis_internal {

/// Counts the evaluations of a likelihood.
struct Counted {
  double (*l)(double);
  int* asked;

  std::vector<double> operator()(const std::vector<double>& x) const {
    std::vector<double> values;
    for (const double at : x) values.push_back(l(at));
    *asked += static_cast<int>(x.size());
    return values;
  }
};

/// Returns the log likelihood of the size of 4,000 errors that have the size 1.7.
double OneSizeLogLikelihood(double x) {
  return -4000.0 * (x + 0.5 * 1.7 * 1.7 * std::exp(-2.0 * x));
}

TEST(FindPeak, OfErrorsOfOneSizeIsFoundFromFar) {
  int asked = 0;
  const auto peak =
      FindPeak(Counted{&OneSizeLogLikelihood, &asked}, {-2.3, -1.15, 0.0, 1.15, 2.3}, -3.5, 3.5);
  ASSERT_TRUE(peak);
  EXPECT_NEAR(peak->log_size, std::log(1.7), 1e-6);
  EXPECT_NEAR(peak->value, OneSizeLogLikelihood(std::log(1.7)), 1e-6);
  EXPECT_NEAR(peak->width, 1.0 / std::sqrt(8000.0), 1e-5);
  EXPECT_LE(asked, 9);
}

/// Returns the log likelihood of a size that enlarges the errors of a hundred components. They have
/// d from 1e-3 to 1e3 and c^2 = 1 + 4 d.
double AddedSizeLogLikelihood(double x) {
  const double v = std::exp(2.0 * x);
  double l = 0.0;
  for (int k = 0; k < 100; ++k) {
    const double d = std::pow(10.0, -3.0 + 0.06 * k);
    const double c2 = d * (1.0 + 4.0 * d);
    l += 0.5 * (v * c2 / (1.0 + v * d) - std::log1p(v * d));
  }
  return l;
}

TEST(FindPeak, OfASizeBesideOthersIsFound) {
  int asked = 0;
  const auto peak =
      FindPeak(Counted{&AddedSizeLogLikelihood, &asked}, {-2.3, -1.15, 0.0, 1.15, 2.3}, -3.5, 3.5);
  ASSERT_TRUE(peak);
  // v = 4 makes every term stationary.
  EXPECT_NEAR(peak->log_size, std::log(2.0), 0.1 * peak->width);
  constexpr double kStep = 1e-3;
  const double at = std::log(2.0);
  const double curvature = (2.0 * AddedSizeLogLikelihood(at) - AddedSizeLogLikelihood(at - kStep) -
                            AddedSizeLogLikelihood(at + kStep)) /
                           (kStep * kStep);
  EXPECT_NEAR(peak->width, 1.0 / std::sqrt(curvature), 0.05 * peak->width);
  EXPECT_LE(asked, 14);
}

TEST(FindPeak, BeyondThePlacesAskedForIsFound) {
  int asked = 0;
  const auto peak = FindPeak(Counted{&OneSizeLogLikelihood, &asked}, {-0.7, -0.6, -0.5}, -5.0, 5.0);
  ASSERT_TRUE(peak);
  EXPECT_NEAR(peak->log_size, std::log(1.7), 1e-4);
}

TEST(FindPeak, OfOneThatOnlyRisesOrFallsIsNone) {
  int asked = 0;
  for (double (*l)(double) :
       {+[](double x) { return x; }, +[](double x) { return -x; }, +[](double) { return 0.0; },
        +[](double) { return std::numeric_limits<double>::quiet_NaN(); }}) {
    EXPECT_FALSE(FindPeak(Counted{l, &asked}, {-0.2, 0.0, 0.2}, -3.5, 3.5));
  }
  EXPECT_LT(asked, 80);
}

TEST(FindPeak, WhatIsNotSmoothHasNoPeakThatWasNotSeen) {
  int asked = 0;
  const auto edge = [](double x) { return x < 0.3 ? 1e4 * x : -x; };
  const auto peak = FindPeak(Counted{edge, &asked}, {-1.0, 0.0, 1.0}, -3.5, 3.5);
  EXPECT_TRUE(!peak || peak->value <= 3000.0);
  EXPECT_LT(asked, 40);
}

}  // namespace dn::diagnosis_internal
