#include <dn/error.h>
#include <dn/sim/random.h>
#include <dn/sim/terrain_caster.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace dn::sim_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSame_m = 1e-6;

struct Landscape {
  std::string name;
  TerrainScenario scenario;
};

TerrainScenario Shape(TerrainKind kind, double relief_m, double wavelength_m) {
  TerrainScenario scenario;
  scenario.kind = kind;
  scenario.base_m = 400.0;
  scenario.relief_m = relief_m;
  scenario.wavelength_m = wavelength_m;
  scenario.seed = 7;
  return scenario;
}

std::vector<Landscape> Landscapes() {
  std::vector<Landscape> all{{"built_up", Shape(TerrainKind::kBuiltUp, 20, 400)},
                             {"mixed", Shape(TerrainKind::kMixed, 60, 900)},
                             {"natural", Shape(TerrainKind::kNatural, 80, 700)},
                             {"mountain", Shape(TerrainKind::kMountain, 1100, 3500)},
                             {"flat", Shape(TerrainKind::kFlat, 0, 100)},
                             {"water", Shape(TerrainKind::kNatural, 30, 300)}};
  all[0].scenario.buildings_per_km2 = 1500;
  all[1].scenario.buildings_per_km2 = 500;
  all[1].scenario.trees_per_km2 = 2000;
  all[1].scenario.roughness_m = 0.05;
  all[2].scenario.trees_per_km2 = 10000;
  all[2].scenario.roughness_m = 0.1;
  all[3].scenario.roughness_m = 0.3;
  all[4].scenario.roughness_m = 0.02;
  all[5].scenario.roughness_m = 0.1;
  all[5].scenario.water_share = 0.4;
  return all;
}

/// Ray from 300 m above the highest point, up to 65 deg from nadir.
struct RandomRay {
  RandomRay(const Terrain& terrain, Random& random)
      : origin_m(random.Uniform(-2e3, 2e3), random.Uniform(-2e3, 2e3),
                 terrain.highest_m() + 300.0) {
    const double off_nadir = random.Uniform(0.0, 1.13), azimuth = random.Uniform(0.0, 6.28);
    direction = {std::sin(off_nadir) * std::cos(azimuth), std::sin(off_nadir) * std::sin(azimuth),
                 -std::cos(off_nadir)};
  }
  Vector3d At(double range_m) const { return origin_m + range_m * direction; }

  Vector3d origin_m, direction;
};

double Above(const Terrain& terrain, const Vector3d& point_m) {
  return point_m.z() - terrain.Surface(point_m.head<2>());
}

class EveryLandscape : public ::testing::TestWithParam<Landscape> {};

TEST_P(EveryLandscape, CasterAgreesWithSmallSteps) {
  const Terrain terrain(GetParam().scenario);
  TerrainCaster caster(terrain);
  Random random(1, "rays");
  constexpr int kRays = 400;
  int nearer = 0;
  for (int i = 0; i < kRays; ++i) {
    const RandomRay ray(terrain, random);
    const auto stepped_m = terrain.Intersect(ray.origin_m, ray.direction, 2e4);
    const auto hit = caster.Cast(ray.origin_m, ray.direction, 2e4);
    ASSERT_TRUE(stepped_m && hit);
    ASSERT_LE(hit->range_m, *stepped_m + kSame_m);
    EXPECT_LE(Above(terrain, ray.At(hit->range_m + kSame_m)), 0.0);
    for (double back_m = kSame_m; back_m < 5.0; back_m += 0.05) {
      ASSERT_GT(Above(terrain, ray.At(hit->range_m - back_m)), -1e-9);
    }
    if (hit->range_m < *stepped_m - kSame_m) ++nearer;  // objects narrower than a step
  }
  EXPECT_LE(nearer, kRays / 40);
}

/// Returns the first of all steps of 0.25 m that is not above the surface, refined by bisection. It
/// skips no steps.
double StepByStep(const Terrain& terrain, const RandomRay& ray) {
  double above_m = (terrain.highest_m() - ray.origin_m.z()) / ray.direction.z();
  while (Above(terrain, ray.At(above_m + 0.25)) > 0.0) above_m += 0.25;
  double below_m = above_m + 0.25;
  for (int i = 0; i < 40; ++i) {
    const double middle_m = 0.5 * (above_m + below_m);
    (Above(terrain, ray.At(middle_m)) > 0.0 ? above_m : below_m) = middle_m;
  }
  return below_m;
}

TEST_P(EveryLandscape, SkippedStepsMeetNothing) {
  const Terrain terrain(GetParam().scenario);
  Random random(3, "rays");
  constexpr int kRays = 100;
  for (int i = 0; i < kRays; ++i) {
    const RandomRay ray(terrain, random);
    const auto hit_m = terrain.Intersect(ray.origin_m, ray.direction, 2e4);
    ASSERT_TRUE(hit_m);
    EXPECT_EQ(*hit_m, StepByStep(terrain, ray));
  }
}

TEST_P(EveryLandscape, RoughGroundStaysWithinItsBounds) {
  const TerrainScenario& scenario = GetParam().scenario;
  const Roughness roughness(scenario.roughness_m, 7);
  constexpr double kStep_m = 0.01;
  double squares = 0.0;
  int count = 0;
  for (double e = -300.0; e < 300.0; e += 3.17) {
    for (double n = -300.0; n < 300.0; n += 3.71, ++count) {
      const double height_m = roughness.At({e, n});
      squares += height_m * height_m;
      EXPECT_LE(std::abs(height_m), roughness.bound_m());
      const double slope = (roughness.At({e + kStep_m, n - kStep_m}) - height_m) / kStep_m;
      EXPECT_LE(std::abs(slope), std::sqrt(2.0) * roughness.slope_bound());
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), scenario.roughness_m, 0.1 * scenario.roughness_m);
}

INSTANTIATE_TEST_SUITE_P(TerrainCaster, EveryLandscape, ::testing::ValuesIn(Landscapes()),
                         [](const auto& each) { return each.param.name; });

TEST(TerrainCaster, KnowsWaterAndItsShare) {
  const TerrainScenario scenario = Landscapes().back().scenario;
  const Terrain terrain(scenario);
  TerrainCaster caster(terrain);
  Random random(2, "rays");
  constexpr int kRays = 2000;
  int wet = 0;
  double level_m = 0.0;
  for (int i = 0; i < kRays; ++i) {
    const RandomRay ray(terrain, random);
    const auto hit = caster.Cast(ray.origin_m, ray.direction, 2e4);
    ASSERT_TRUE(hit);
    if (hit->surface != Surface::kWater) continue;
    const double height_m = ray.At(hit->range_m).z();
    if (wet++ == 0) level_m = height_m;
    EXPECT_NEAR(height_m, level_m, kSame_m);
  }
  EXPECT_NEAR(static_cast<double>(wet) / kRays, scenario.water_share, 0.1);
}

TEST(TerrainCaster, ReachesNoFartherThanAskedAndOnlyDownwards) {
  const Terrain terrain(Landscapes().front().scenario);
  TerrainCaster caster(terrain);
  const Vector3d origin_m(0.0, 0.0, terrain.highest_m() + 100.0);
  EXPECT_FALSE(caster.Cast(origin_m, -Vector3d::UnitZ(), 99.0));
  EXPECT_TRUE(caster.Cast(origin_m, -Vector3d::UnitZ(), 200.0));
  EXPECT_THROW(caster.Cast(origin_m, Vector3d::UnitX(), 200.0), InvalidInput);
}

}  // namespace dn::sim_test
