#include <dn/lidar/strip_io.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>
#include <dn/sim/terrain_caster.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "small_scenario.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

using Eigen::Vector3d;

/// Returns a flight of a few pulses per square metre over 300 m of a detailed terrain.
Scenario DetailedScenario(const std::string& terrain, const std::string& lidar = "") {
  return ParseScenario(R"(
name: detailed
origin_deg_m: [46.57, 6.52, 400]
start_s: 381000
plan:
  warm_up_s: 20
  lines: [[-40, 0, 40, 0, 300, 40], [40, 60, -40, 60, 300, 40]]
terrain: {)" + terrain + R"(, relief_m: 10, wavelength_m: 300, seed: 3}
imu: {rate_hz: 20, preset: ln200}
gnss: {rate_hz: 2}
lidar: {R_sensor_to_body: [[0,1,0],[0,0,1],[1,0,0]], scan_axis: [0,1,0], nadir_axis: [1,0,0],
        fov_deg: 30, gsd_m: 0.5, pulse_rate_hz: 15000, beam_divergence_mrad: 0.8)" +
                           lidar + R"(}
pairs: {count: 0}
strips: true
)",
                       "detailed.yaml");
}

StripCloud Points(const Scenario& scenario, std::size_t strip, int threads = 1) {
  const SimulatedFlight flight = Simulate(scenario, {.seed = 5});
  const testing::TempFolder folder;
  flight.clouds->Write(strip, folder.path() / "strip.las", threads, nullptr);
  StripCloud all;
  const auto reader = OpenStrip(folder.path() / "strip.las");
  for (StripCloud some; reader->Next(&some);) {
    const auto append = [](const auto& from, auto* to) {
      to->insert(to->end(), from.begin(), from.end());
    };
    append(some.p_c, &all.p_c);
    append(some.t_s, &all.t_s);
    append(some.u_s, &all.u_s);
    append(some.intensity, &all.intensity);
    append(some.return_number, &all.return_number);
    append(some.returns_after, &all.returns_after);
    append(some.classification, &all.classification);
    append(some.flags, &all.flags);
  }
  return all;
}

double Share(const StripCloud& points, const std::set<int>& classes) {
  double count = 0.0;
  for (const std::uint8_t each : points.classification) count += classes.contains(each) ? 1.0 : 0.0;
  return count / static_cast<double>(points.size());
}

double ReturnsPerPulse(const StripCloud& points) {
  const auto pulses = std::count(points.return_number.begin(), points.return_number.end(), 1);
  return static_cast<double>(points.size()) / static_cast<double>(pulses);
}

/// Returns the share of vertical rays at random places within 2 km that meet a tree.
double TreeShare(double woods_share) {
  TerrainScenario scenario;
  scenario.kind = TerrainKind::kNatural;
  scenario.woods_share = woods_share;
  const Terrain terrain(scenario);
  TerrainCaster caster(terrain);
  Random random(1, "rays");
  constexpr int kRays = 2000;
  int trees = 0;
  for (int k = 0; k < kRays; ++k) {
    const Vector3d origin_m(random.Uniform(-2e3, 2e3), random.Uniform(-2e3, 2e3), 200.0);
    const auto hit = caster.Cast(origin_m, -Vector3d::UnitZ(), 1e3);
    trees += hit && hit->surface == Surface::kHighPlant ? 1 : 0;
  }
  return static_cast<double>(trees) / kRays;
}

TEST(DetailedTerrain, WoodsCoverTheirShareOfNaturalGround) {
  const double forest = TreeShare(1.0);
  EXPECT_GT(forest, 0.4);
  for (const double woods_share : {0.2, 0.4, 0.7}) {
    EXPECT_NEAR(TreeShare(woods_share) / forest, woods_share, 0.1);
  }
  EXPECT_EQ(TreeShare(0.0), 0.0);
}

// Only point clouds see woods: the ground, and with it the pairs, stay the same.
TEST(DetailedTerrain, WoodsDoNotChangeTheGround) {
  TerrainScenario scenario;
  scenario.kind = TerrainKind::kMixed;
  scenario.relief_m = 20.0;
  scenario.wavelength_m = 300.0;
  scenario.buildings_per_km2 = 300.0;
  const Terrain bare(scenario);
  scenario.woods_share = 0.5;
  const Terrain wooded(scenario);
  Random random(1, "places");
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector2d at_m(random.Uniform(-2000.0, 2000.0), random.Uniform(-2000.0, 2000.0));
    EXPECT_EQ(bare.Surface(at_m), wooded.Surface(at_m));
  }
}

TEST(DetailedTerrain, AForestGivesAsManyReturnsAsAMeasuredOne) {
  const StripCloud points = Points(DetailedScenario("kind: forest", ", noise_share: 0"), 0);
  EXPECT_GT(points.size(), 30000u);
  EXPECT_NEAR(ReturnsPerPulse(points), 1.5, 0.2);
  EXPECT_GT(Share(points, {2}), 0.1);  // some light reaches the ground
  EXPECT_GT(Share(points, {5}), 0.4);
}

TEST(DetailedTerrain, BareTreesLetMoreLightThrough) {
  const auto ground = [](const std::string& keys) {
    return Share(Points(DetailedScenario("kind: forest, conifer_share: 0" + keys), 0), {2});
  };
  EXPECT_GT(ground(", leaves: false"), 1.2 * ground(""));
}

TEST(DetailedTerrain, ReturnsOfAPulseAreNumberedAndApart) {
  constexpr double kResolution_m = 2.5, kNoise_m = 0.2;
  const StripCloud points = Points(DetailedScenario("kind: forest"), 0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points.return_number[i] == 1) {
      ASSERT_EQ(points.returns_after[i - 1], 0);
      continue;
    }
    ASSERT_EQ(points.t_s[i], points.t_s[i - 1]);
    ASSERT_EQ(points.return_number[i], points.return_number[i - 1] + 1);
    ASSERT_EQ(points.returns_after[i], points.returns_after[i - 1] - 1);
    const bool noise = points.classification[i] == 7 || points.classification[i - 1] == 18;
    if (!noise) {
      ASSERT_GT(points.u_s[i].norm(), points.u_s[i - 1].norm() + kResolution_m - kNoise_m - 0.6);
    }
  }
}

TEST(DetailedTerrain, PointsDoNotDependOnTheNumberOfThreads) {
  const Scenario scenario = DetailedScenario("kind: town");
  const StripCloud one = Points(scenario, 1, 1), two = Points(scenario, 1, 2);
  EXPECT_EQ(one.p_c, two.p_c);
  EXPECT_EQ(one.intensity, two.intensity);
}

TEST(DetailedTerrain, NoisePointsHaveTheirClassAndSomeAreWithheld) {
  const StripCloud points = Points(DetailedScenario("kind: fields", ", noise_share: 0.02"), 0);
  EXPECT_NEAR(Share(points, {7, 18}), 0.02, 0.004);
  double noise = 0.0, withheld = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool is_noise = points.classification[i] == 7 || points.classification[i] == 18;
    const bool is_withheld = points.flags[i] == StripCloud::kWithheld;
    EXPECT_TRUE(is_noise || !is_withheld);
    noise += is_noise ? 1.0 : 0.0;
    withheld += is_withheld ? 1.0 : 0.0;
  }
  EXPECT_NEAR(withheld / noise, 0.5, 0.1);
}

TEST(DetailedTerrain, WaterReturnsOnlyBelowTheScannerAndMoves) {
  Scenario scenario = DetailedScenario("kind: fields, water_share: 0.4");
  scenario.lidar.fov_rad = 1.0;
  const StripCloud points = Points(scenario, 0);
  double squares = 0.0, sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.classification[i] != 9) continue;
    EXPECT_LT(std::abs(points.u_s[i].z()) / points.u_s[i].x(), 0.35);
    sum += points.p_c[i].z();
    squares += points.p_c[i].z() * points.p_c[i].z();
    count += 1.0;
  }
  ASSERT_GT(count, 20.0);
  const double rms_m = std::sqrt(squares / count - sum * sum / count / count);
  EXPECT_NEAR(rms_m, std::hypot(0.03, 0.02), 0.015);
}

/// Ray from 200 m above the ground, up to 30 deg from nadir.
struct SlantRay {
  explicit SlantRay(Random* random) {
    const double east_m = random->Uniform(-300.0, 300.0), north_m = random->Uniform(-300.0, 300.0);
    const double off = random->Uniform(0.0, 0.5), azimuth = random->Uniform(0.0, 6.28);
    origin_m = {east_m, north_m, 200.0};
    direction = {std::sin(off) * std::cos(azimuth), std::sin(off) * std::sin(azimuth),
                 -std::cos(off)};
  }
  Vector3d origin_m, direction;
};

class EveryDetailedKind : public ::testing::TestWithParam<TerrainKind> {};

TerrainScenario DetailedTerrain(TerrainKind kind) {
  TerrainScenario scenario;
  scenario.kind = kind;
  scenario.relief_m = 10.0;
  scenario.wavelength_m = 300.0;
  scenario.roughness_m = 0.05;
  scenario.trees_per_km2 = 20000.0;
  scenario.buildings_per_km2 = 900.0;
  scenario.cars_per_km2 = 3000.0;
  scenario.seed = 4;
  return scenario;
}

TEST_P(EveryDetailedKind, ARayEndsAtTheSamePlaceFromWhereverItStarts) {
  const Terrain terrain(DetailedTerrain(GetParam()));
  TerrainCaster caster(terrain, 1), other(terrain, 1);
  Random random(1, "rays");
  std::map<Surface, int> met;
  for (int i = 0; i < 3000; ++i) {
    const SlantRay ray(&random);
    const auto hit = caster.Cast(ray.origin_m, ray.direction, 1e3);
    ASSERT_TRUE(hit);
    ++met[hit->surface];
    EXPECT_GE(hit->cosine, 0.0);
    EXPECT_LE(hit->cosine, 1.0 + 1e-12);
    for (const double before_m : {0.03, 1.7, 40.0}) {
      const double skipped_m = hit->range_m - before_m;
      const auto near = other.Cast(ray.origin_m + skipped_m * ray.direction, ray.direction, 1e3);
      ASSERT_TRUE(near);
      EXPECT_NEAR(near->range_m, before_m, 1e-6) << i;
    }
  }
  EXPECT_GT(met[Surface::kGround], 300);
  if (GetParam() == TerrainKind::kTown) {
    EXPECT_GT(met[Surface::kCar], 10);
    EXPECT_GT(met[Surface::kBuilding], 300);
  }
}

INSTANTIATE_TEST_SUITE_P(DetailedTerrain, EveryDetailedKind,
                         ::testing::Values(TerrainKind::kForest, TerrainKind::kOrchard,
                                           TerrainKind::kTown, TerrainKind::kQuarry,
                                           TerrainKind::kFields));

TEST(DetailedTerrain, SomeCarsAreElsewhereOnTheNextVisit) {
  const Terrain terrain(DetailedTerrain(TerrainKind::kTown));
  TerrainCaster first(terrain, 1), second(terrain, 2);
  int stayed = 0, moved = 0, other = 0;
  for (double east_m = -200.0; east_m < 200.0; east_m += 1.3) {
    for (double north_m = -200.0; north_m < 200.0; north_m += 1.3) {
      const Vector3d origin_m(east_m, north_m, 200.0);
      const auto a = first.Cast(origin_m, -Vector3d::UnitZ(), 1e3);
      const auto b = second.Cast(origin_m, -Vector3d::UnitZ(), 1e3);
      const bool car_a = a->surface == Surface::kCar, car_b = b->surface == Surface::kCar;
      stayed += car_a && car_b ? 1 : 0;
      moved += car_a != car_b ? 1 : 0;
      other += !car_a && !car_b && a->range_m != b->range_m ? 1 : 0;
    }
  }
  EXPECT_GT(stayed, 100);
  EXPECT_GT(moved, 100);
  EXPECT_EQ(other, 0);
}

TEST(DetailedTerrain, ScansOfTwoStripsDiffer) {
  const auto scans = [](const std::string& lidar) {
    const Scenario scenario = DetailedScenario("kind: fields", lidar);
    const SimulatedFlight flight = Simulate(scenario, {.seed = 5, .noise = false});
    std::vector<double> angles;
    for (const std::size_t strip : {0u, 1u}) {
      flight.clouds->Run(
          strip, 1,
          [&](const StripCloud& some) {
            if (angles.size() == strip) angles.push_back(some.u_s[0].z() / some.u_s[0].norm());
          },
          nullptr);
    }
    return angles;
  };
  const auto same = scans(", scan_variation: 0"), varied = scans("");
  EXPECT_NEAR(same[0], same[1], 1e-9);
  EXPECT_GT(std::abs(varied[0] - varied[1]), 1e-3);
}

TEST(DetailedTerrain, AZigzagSwingsBothWays) {
  const StripCloud points =
      Points(DetailedScenario("kind: fields", ", pattern: zigzag, max_returns: 1"), 0);
  int rises = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points.u_s[i].z() > points.u_s[i - 1].z()) ++rises;
  }
  EXPECT_NEAR(rises / static_cast<double>(points.size()), 0.5, 0.05);
}

}  // namespace dn::sim_test
