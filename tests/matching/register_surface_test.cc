#include "register_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "agree_with_neighbours.h"
#include "match_cells.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector3d;

constexpr double kGsd_m = 0.5, kHalf_m = 24.0, kNoise_m = 0.02;
const Vector3d kSlope(0.05, -0.1, 1.0);  // normal of the field, not normalised

/// A field with a slope and a gentle swell, scanned at random places.
std::vector<Vector3d> ScanField(double up_m, unsigned seed, double swell_m = 0.05) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-kHalf_m - 3.0, kHalf_m + 3.0);
  std::normal_distribution<double> noise(0.0, kNoise_m);
  std::vector<Vector3d> points;
  const auto count = static_cast<std::size_t>(std::pow(2.0 * (kHalf_m + 3.0) / kGsd_m, 2));
  for (std::size_t k = 0; k < count; ++k) {
    const double x = place(random), y = place(random);
    const double z = -kSlope.x() * x - kSlope.y() * y + swell_m * std::sin(0.15 * x + 0.1 * y);
    points.emplace_back(x, y, z + up_m + noise(random));
  }
  return points;
}

PatchSurface Surface(double up_m, unsigned seed, double swell_m = 0.05) {
  return {ScanField(up_m, seed, swell_m), kReach_gsd * kGsd_m};
}

const RegisterOptions kOptions{{{0.0, 0.0}, kHalf_m}, kGsd_m, 8000};

TEST(RegisterSurface, ASmoothFieldHasAnHonestDistance) {
  double squares = 0.0, sum_m = 0.0;
  constexpr unsigned kRuns = 40;
  const Vector3d normal = kSlope.normalized();
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    // The start is half a metre off, horizontally, which must not matter.
    const auto found = RegisterSurface(Surface(0.0, 2 * seed), Surface(0.3, 2 * seed + 1),
                                       Vector3d(0.4, -0.3, 0.1), kOptions);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->normal_m.dot(normal), 1.0, 1e-4);
    const double sigma_m = std::sqrt(found->Variance(std::max(1.0, found->variance_ratio)));
    EXPECT_LT(sigma_m, 0.001);
    const double error_m = normal.dot(found->shift_m - Vector3d(0.0, 0.0, 0.3));
    squares += std::pow(error_m / sigma_m, 2);
    sum_m += error_m;
  }
  // The 99.9 % band of a mean of 40 squares is 0.4 to 1.9.
  EXPECT_GT(squares / kRuns, 0.4);
  EXPECT_LT(squares / kRuns, 1.9);
  EXPECT_LT(std::abs(sum_m / kRuns), 0.0002);
}

// The whole field has no features: a shift is not determined, but a distance is.
TEST(MatchCells, ASmoothFieldIsASurface) {
  const PatchSurface a = Surface(0.0, 1, 0.0), b = Surface(0.3, 2, 0.0);
  MatchCellsOptions options{kOptions.cell, kGsd_m, 3.0};
  EXPECT_TRUE(MatchCells(a, b, Vector3d::Zero(), options).surfaces.empty());
  options.with_surfaces = true;
  const CellMatches matches = MatchCells(a, b, Vector3d::Zero(), options);
  EXPECT_TRUE(matches.cells.empty());
  EXPECT_EQ(matches.surfaces.size(), 1u);
}

TEST(RegisterSurface, RoughGroundIsNone) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-kHalf_m, kHalf_m), height(0.0, 5.0);
  std::vector<Vector3d> points;
  for (int k = 0; k < 9000; ++k) {
    points.emplace_back(place(random), place(random), height(random));
  }
  const PatchSurface a(points, kReach_gsd * kGsd_m);
  EXPECT_FALSE(RegisterSurface(a, a, Vector3d::Zero(), kOptions));
}

TEST(AgreeInHeight, AWrongHeightIsFoundAndTheNoiseIsEstimated) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.02);
  std::vector<PlacedHeight> heights;
  for (int k = 0; k < 100; ++k) {
    const int row = k / 10;
    heights.push_back({{10.0 * (k % 10), 10.0 * row}, noise(random), 1e-4});
  }
  heights[42].shift_m = 0.5;
  const HeightAgreement agreement = AgreeInHeight(heights);
  EXPECT_FALSE(agreement.agrees[42]);
  EXPECT_GE(std::count(agreement.agrees.begin(), agreement.agrees.end(), true), 97);
  EXPECT_NEAR(agreement.variance_factor, 4.0, 1.2);
}

}  // namespace
}  // namespace dn::matching_internal
