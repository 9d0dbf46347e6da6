#include <dn/adjustment/control_search.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace dn::adjustment_test {

using Eigen::Vector3d;

/// Returns of a slope around the origin: up = 5 + 0.3 east - 0.2 north.
std::vector<NearReturn> Slope(int count, double noise_m, std::mt19937& rng) {
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  std::normal_distribution<double> normal;
  std::vector<NearReturn> returns;
  while (static_cast<int>(returns.size()) < count) {
    const double e = place(rng), n = place(rng);
    if (e * e + n * n > 1.0) continue;
    returns.push_back(
        {{e, n, 5.0 + 0.3 * e - 0.2 * n + noise_m * normal(rng)}, 0.0, Vector3d::Zero()});
  }
  return returns;
}

const Vector3d kPoint(0.0, 0.0, 4.9);

TEST(FitSurface, GivesTheHeightAndItsSigmaDespiteOutliers) {
  constexpr int kRuns = 200;
  double squares = 0.0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::vector<NearReturn> returns = Slope(30, 0.02, rng);
    for (std::size_t k = 0; k < 5; ++k) returns[k].x_m.z() += 1.0 + 0.3 * static_cast<double>(k);
    const auto fit = FitSurface(returns, kPoint);
    ASSERT_TRUE(fit);
    EXPECT_NEAR((fit->normal_m - Vector3d(-0.3, 0.2, 1.0).normalized()).norm(), 0.0, 0.1);
    for (const std::size_t k : fit->inliers) EXPECT_GE(k, 5u);
    squares += std::pow((fit->foot_m.z() - 5.0) * fit->normal_m.z() / fit->sigma_m, 2);
  }
  EXPECT_NEAR(squares / kRuns, 1.0, 0.4);  // 4 sigma of 200 squares, and of trimmed noise
}

TEST(FitSurface, WantsReturnsAroundThePointOnOneSurface) {
  std::mt19937 rng(1);
  EXPECT_FALSE(FitSurface({}, kPoint));
  EXPECT_FALSE(FitSurface(Slope(5, 0.01, rng), kPoint));
  std::vector<NearReturn> beside = Slope(30, 0.01, rng), line = beside, wall = beside, two = beside;
  for (NearReturn& one : beside) one.x_m.x() += 3.0;
  EXPECT_FALSE(FitSurface(beside, kPoint));
  for (NearReturn& one : line) one.x_m.y() = one.x_m.x();
  EXPECT_FALSE(FitSurface(line, kPoint));
  for (NearReturn& one : wall) one.x_m.z() = 4.9 + 3.0 * one.x_m.x();
  EXPECT_FALSE(FitSurface(wall, kPoint));
  for (std::size_t k = 0; k < two.size(); ++k) {
    two[k].x_m.z() += k % 3 == 0 ? 0.0 : 2.0 * static_cast<double>(k % 7);
  }
  EXPECT_FALSE(FitSurface(two, kPoint));
}

}  // namespace dn::adjustment_test
