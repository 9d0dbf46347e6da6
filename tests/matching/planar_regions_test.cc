#include <dn/error.h>
#include <dn/matching/planar_regions.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "testing/roofs.h"

namespace dn::matching_test {

using Eigen::Vector3d;
using testing::Roof;
using testing::SurfaceHeight;

constexpr double kRegionSpacingM = 0.4;
constexpr double kRegionNoiseM = 0.02;

/// Returns a cloud over 60 x 60 m of a surface with noise.
template <class Height>
std::vector<Vector3d> Scan(const Height& height, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0.0, kRegionNoiseM);
  std::uniform_real_distribution<double> jitter(-0.1, 0.1);
  std::vector<Vector3d> points_m;
  for (double x = -30.0; x < 30.0; x += kRegionSpacingM) {
    for (double y = -30.0; y < 30.0; y += kRegionSpacingM) {
      const double e = x + jitter(rng), n = y + jitter(rng);
      points_m.emplace_back(1000.0 + e, -2000.0 + n, 400.0 + height(e, n) + noise(rng));
    }
  }
  return points_m;
}

const Roof kGable{{0.0, 0.0}, 10.0, 7.0, 0.6, 6.0};

TEST(GrowPlanarRegions, FindsBothSidesOfAGable) {
  const std::vector<Vector3d> points_m = Scan(
      [](double e, double n) {
        return SurfaceHeight({kGable}, {e, n});
      },
      1);
  const auto regions =
      GrowPlanarRegions(points_m, PlanarRegionOptions::ForSpacing(kRegionSpacingM));
  int sides = 0;
  for (const PlanarRegion& region : regions) {
    const double slope = std::acos(region.normal.z());
    EXPECT_LT(region.rms_m, 1.3 * kRegionNoiseM);
    EXPECT_TRUE(std::is_sorted(region.points.begin(), region.points.end()));
    if (slope < 0.1) continue;  // a region of the ground
    ++sides;
    EXPECT_NEAR(slope, 0.6, 0.01);
    EXPECT_GT(region.short_side_m, 4.0);
    EXPECT_NEAR(std::abs(region.normal.x()) / std::sin(0.6), 1.0, 0.02);
  }
  EXPECT_EQ(sides, 2);
}

TEST(GrowPlanarRegions, CutsTheGroundAndAcceptsNoPointTwice) {
  const std::vector<Vector3d> points_m = Scan([](double, double) { return 0.0; }, 2);
  PlanarRegionOptions options = PlanarRegionOptions::ForSpacing(kRegionSpacingM);
  const auto regions = GrowPlanarRegions(points_m, options);
  EXPECT_GE(regions.size(), 16u);  // (60 m / 15 m)^2
  std::vector<int> used(points_m.size(), 0);
  for (const PlanarRegion& region : regions) {
    EXPECT_LT(region.long_side_m, 1.1 * options.max_extent_m);
    for (const std::size_t i : region.points) EXPECT_EQ(++used[i], 1);
  }
}

TEST(GrowPlanarRegions, NothingOnRoughGround) {
  std::mt19937 rng(3);
  std::normal_distribution<double> rough(0.0, 0.3);
  const std::vector<Vector3d> points_m = Scan([&](double, double) { return rough(rng); }, 3);
  EXPECT_TRUE(
      GrowPlanarRegions(points_m, PlanarRegionOptions::ForSpacing(kRegionSpacingM)).empty());
}

TEST(GrowPlanarRegions, RoughGroundIsNoPlaneHoweverFarItsPointsAreApart) {
  std::mt19937 rng(4);
  std::normal_distribution<double> rough(0.0, 0.16);
  std::vector<Vector3d> points_m;
  for (double e = 0.0; e < 60.0; e += 1.0) {
    for (double n = 0.0; n < 60.0; n += 1.0) points_m.emplace_back(e, n, rough(rng));
  }
  PlanarRegionOptions options = PlanarRegionOptions::ForSpacing(1.0);
  EXPECT_EQ(options.max_rms_m, 0.08);
  EXPECT_TRUE(GrowPlanarRegions(points_m, options).empty());
  options.max_rms_m = 1.0 / 6.0;
  EXPECT_FALSE(GrowPlanarRegions(points_m, options).empty());
}

TEST(GrowPlanarRegions, NothingOnFewOrNoPoints) {
  EXPECT_TRUE(GrowPlanarRegions({}, {}).empty());
  EXPECT_TRUE(GrowPlanarRegions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}).empty());
}

TEST(GrowPlanarRegions, RejectsBadInput) {
  EXPECT_THROW(GrowPlanarRegions({}, {.max_rms_m = 0.0}), InvalidConfig);
  EXPECT_THROW(GrowPlanarRegions({}, {.min_points = 3}), InvalidConfig);
  std::vector<Vector3d> points_m(40, Vector3d::Zero());
  points_m[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(GrowPlanarRegions(points_m, {}), InvalidInput);
}

}  // namespace dn::matching_test
