#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <dn/sim/terrain.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "sim/small_scenario.h"

namespace dn::sim_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kExact_m = 1e-6;  // 45 m/s times the resolution of time (6e-11 s), with margin

/// Rodrigues' formula, and the georeferencing of docs/reference/conventions.md, written out.
Matrix3d Rotation(const Vector3d& phi) {
  const double angle = phi.norm();
  if (angle == 0.0) return Matrix3d::Identity();
  const Vector3d k = phi / angle;
  Matrix3d K;
  K << 0, -k.z(), k.y(), k.z(), 0, -k.x(), -k.y(), k.x(), 0;
  return Matrix3d::Identity() + std::sin(angle) * K + (1.0 - std::cos(angle)) * K * K;
}

Vector3d Ground(const SimulatedFlight& flight, double t_s, const Vector3d& u_s,
                const Vector3d& lever_arm_b_m) {
  const MapPose pose = flight.truth->Pose(t_s);
  const Vector3d u_b =
      Rotation(flight.boresight_rad) * flight.scenario.lidar.mounting.R_bs_nominal * u_s;
  return pose.p_mb + pose.q_mb.toRotationMatrix() * (u_b + lever_arm_b_m);
}

TEST(SimulatedPairs, BothEndsAreOneGroundPointInTheScanPlane) {
  const Scenario scenario = testing::SmallScenario();
  const SimulatedFlight flight = Simulate(scenario, {.noise = false});
  const Terrain terrain(scenario.terrain);
  const double half_fov = 0.5 * scenario.lidar.fov_rad;
  std::map<int, int> per_file;
  double widest = 0.0;
  ASSERT_EQ(flight.flight.pairs->pairs.size(), 300u);
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    ++per_file[pair.file];
    const Vector3d& a = scenario.lidar.mounting.lever_arm_b_m;
    const Vector3d p_i = Ground(flight, pair.t_i_s, pair.u_i_s, a);
    const Vector3d p_j = Ground(flight, pair.t_j_s, pair.u_j_s, a);
    EXPECT_LT((p_i - p_j).norm(), kExact_m);
    EXPECT_NEAR(p_i.z(), terrain.Surface(p_i.head<2>()), 1e-4);
    for (const Vector3d& u : {pair.u_i_s, pair.u_j_s}) {
      EXPECT_LT(std::abs(u.y()), kExact_m);  // the scan axis is (0, 1, 0)
      // The direction scan x nadir is (0,1,0) x (1,0,0) = (0,0,-1).
      const double angle = std::atan2(-u.z(), u.x());
      EXPECT_LE(std::abs(angle), half_fov);
      widest = std::max(widest, std::abs(angle));
    }
  }
  EXPECT_GT(widest, 0.8 * half_fov);  // the whole swath is used
  const auto& files = flight.flight.pairs->files;
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(file.generic_string());
  EXPECT_THAT(names, ::testing::ElementsAre("lidar/1_2.txt", "lidar/1_3.txt", "lidar/2_3.txt"));
  EXPECT_EQ(per_file.size(), files.size());
}

/// Returns sum(x y) over sum(x^2) of the noise of pairs, for neighbours in time of one file.
double NeighbourCorrelation(const Scenario& scenario) {
  const PairData noisy = *Simulate(scenario, {.seed = 5}).flight.pairs;
  const PairData exact = *Simulate(scenario, {.seed = 5, .noise = false}).flight.pairs;
  double product = 0.0, square = 0.0;
  for (std::size_t k = 1; k < noisy.pairs.size(); ++k) {
    const auto error = [&](std::size_t at) {
      return Vector3d(noisy.pairs[at].u_i_s - exact.pairs[at].u_i_s);
    };
    if (noisy.pairs[k].file != noisy.pairs[k - 1].file) continue;
    product += error(k).dot(error(k - 1));
    square += error(k).squaredNorm();
  }
  return product / square;
}

TEST(SimulatedPairs, NeighboursShareAPartOfTheirError) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 2000;
  EXPECT_NEAR(NeighbourCorrelation(scenario), 0.0, 0.05);
  scenario.pairs.shared_fraction = 0.5;
  scenario.pairs.shared_length_m = 1e5;
  // Over the whole flight, an end has half of its own quarter and the whole shared half.
  EXPECT_NEAR(NeighbourCorrelation(scenario), 2.0 / 3.0, 0.25);
}

TEST(SimulatedPairs, ASharedErrorKeepsTheVarianceOfThePairs) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 4000;
  scenario.pairs.shared_fraction = 0.5;
  scenario.pairs.shared_length_m = 5.0;
  const SimulatedFlight noisy = Simulate(scenario, {.seed = 6});
  const SimulatedFlight exact = Simulate(scenario, {.seed = 6, .noise = false});
  const auto& a = noisy.flight.pairs->pairs;
  const auto& b = exact.flight.pairs->pairs;
  double square = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    square += (a[k].u_i_s - b[k].u_i_s).squaredNorm() + (a[k].u_j_s - b[k].u_j_s).squaredNorm();
  }
  const double variance = square / (3.0 * static_cast<double>(a.size()));
  EXPECT_NEAR(variance / std::pow(scenario.pairs.sigma_p_m, 2), 1.0, 0.1);
}

TEST(SimulatedPairs, AreNotOnWater) {
  Scenario scenario = testing::SmallScenario();
  scenario.terrain.water_share = 0.4;
  const SimulatedFlight flight = Simulate(scenario, {.noise = false});
  const Terrain terrain(scenario.terrain);
  const Vector3d& a = scenario.lidar.mounting.lever_arm_b_m;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    const Vector3d p_m = Ground(flight, pair.t_i_s, pair.u_i_s, a);
    EXPECT_FALSE(terrain.Water(p_m.head<2>()));
  }
}

TEST(SimulatedPairs, BothEndsAreOneGroundPointOnTheConeSeenAheadOrBehind) {
  Scenario scenario = testing::SmallScenario();
  scenario.lidar.pattern = ScanPattern::kCone;
  const SimulatedFlight flight = Simulate(scenario, {.noise = false});
  const Terrain terrain(scenario.terrain);
  const Vector3d& a = scenario.lidar.mounting.lever_arm_b_m;
  int ahead = 0, left = 0, mixed = 0;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    const Vector3d p_i = Ground(flight, pair.t_i_s, pair.u_i_s, a);
    const Vector3d p_j = Ground(flight, pair.t_j_s, pair.u_j_s, a);
    EXPECT_LT((p_i - p_j).norm(), kExact_m);
    EXPECT_NEAR(p_i.z(), terrain.Surface(p_i.head<2>()), 1e-4);
    for (const Vector3d& u : {pair.u_i_s, pair.u_j_s}) {
      // The nadir axis is (1, 0, 0) and the scan axis is (0, 1, 0).
      EXPECT_NEAR(u.x(), u.norm() * std::cos(0.5 * scenario.lidar.fov_rad), kExact_m);
      ahead += u.y() > 0.0 ? 1 : 0;
      left += u.z() < 0.0 ? 1 : 0;
    }
    mixed += (pair.u_i_s.y() > 0.0) != (pair.u_j_s.y() > 0.0) ? 1 : 0;
  }
  ASSERT_EQ(flight.flight.pairs->pairs.size(), 300u);
  for (const int count : {ahead, left, 2 * mixed}) {
    EXPECT_GT(count, 200);
    EXPECT_LT(count, 400);
  }
}

TEST(SimulatedPairs, EpochsLieInTheirStrips) {
  const SimulatedFlight flight = Simulate(testing::SmallScenario(), {});
  const auto strip_of = [&](double t_s) -> std::string {
    for (const StripInterval& strip : flight.strips) {
      if (t_s >= strip.t0_s && t_s <= strip.t1_s) return strip.name;
    }
    return "none";
  };
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    const std::string file =
        flight.flight.pairs->files[static_cast<std::size_t>(pair.file)].string();
    EXPECT_EQ(file, "lidar/" + strip_of(pair.t_i_s) + "_" + strip_of(pair.t_j_s) + ".txt");
  }
}

TEST(SimulatedPairs, DifferenceHasTheStatedNoise) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 2000;
  const SimulatedFlight flight = Simulate(scenario, {.seed = 9});
  const Vector3d& a = scenario.lidar.mounting.lever_arm_b_m;
  Vector3d squared = Vector3d::Zero();
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    squared +=
        (Ground(flight, pair.t_i_s, pair.u_i_s, a) - Ground(flight, pair.t_j_s, pair.u_j_s, a))
            .cwiseAbs2();
  }
  const double n = 2000.0;
  const double tolerance = 5.0 * std::sqrt(2.0 / n);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(squared[axis] / n / std::pow(scenario.pairs.sigma_p_m, 2), 1.0, tolerance);
  }
}

TEST(SimulatedPairs, LeverArmEffectMovesTheTrueScanner) {
  const Scenario scenario =
      testing::SmallScenario("effects: [{effect: lidar_lever_arm, value: [0.3, -0.2, 0.1]}]\n");
  const SimulatedFlight flight = Simulate(scenario, {.noise = false});
  const Vector3d assumed = scenario.lidar.mounting.lever_arm_b_m;
  const Vector3d truth = assumed + Vector3d(0.3, -0.2, 0.1);
  EXPECT_EQ(flight.flight.config.lidar->mounting.lever_arm_b_m, assumed);
  EXPECT_LT((flight.lidar_lever_arm_b_m - truth).norm(), 1e-12);
  double misclosure_m = 0.0;
  for (const LidarPair& pair : flight.flight.pairs->pairs) {
    EXPECT_LT((Ground(flight, pair.t_i_s, pair.u_i_s, truth) -
               Ground(flight, pair.t_j_s, pair.u_j_s, truth))
                  .norm(),
              kExact_m);
    misclosure_m = std::max(misclosure_m, (Ground(flight, pair.t_i_s, pair.u_i_s, assumed) -
                                           Ground(flight, pair.t_j_s, pair.u_j_s, assumed))
                                              .norm());
  }
  EXPECT_GT(misclosure_m, 0.3);  // the headings are opposite
}

TEST(SimulatedPairs, TimeOffsetEffectMovesTheTagOnly) {
  const double offset_s = 0.0123;
  const SimulatedFlight plain = Simulate(testing::SmallScenario(), {.noise = false});
  const SimulatedFlight late =
      Simulate(testing::SmallScenario("effects: [{effect: lidar_time_offset, value: 0.0123}]\n"),
               {.noise = false});
  ASSERT_EQ(plain.flight.pairs->pairs.size(), late.flight.pairs->pairs.size());
  for (std::size_t i = 0; i < plain.flight.pairs->pairs.size(); ++i) {
    const LidarPair& a = plain.flight.pairs->pairs[i];
    const LidarPair& b = late.flight.pairs->pairs[i];
    EXPECT_NEAR(b.t_i_s - a.t_i_s, offset_s, 1e-9);
    EXPECT_NEAR(b.t_j_s - a.t_j_s, offset_s, 1e-9);
    EXPECT_EQ(a.u_i_s, b.u_i_s);
    EXPECT_EQ(a.u_j_s, b.u_j_s);
  }
}

TEST(Terrain, RayMeetsTheSurfaceAndHousesHideTheGround) {
  const Terrain terrain(testing::SmallScenario().terrain);
  const Vector3d origin(3.0, -7.0, 200.0);
  int hidden = 0, clipped = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d en(-150.0 + 0.6 * i, 40.0);
    const Vector3d target(en.x(), en.y(), terrain.Surface(en));
    const Vector3d ray = target - origin;
    const auto range_m = terrain.Intersect(origin, ray.normalized(), ray.norm() + 100.0);
    ASSERT_TRUE(range_m.has_value());
    const Vector3d hit = origin + *range_m * ray.normalized();
    EXPECT_LE(hit.z(), terrain.Surface(hit.head<2>()) + 1e-6);
    if (*range_m > ray.norm() + 1e-6) ++clipped;  // the corner of an eave, within one step
    if (*range_m < ray.norm() - 1.0) ++hidden;
  }
  EXPECT_LE(clipped, 10);
  EXPECT_GT(hidden, 5);
  EXPECT_LT(hidden, 250);
}

TEST(Terrain, StaysWithinItsBoundsAndFlatIsFlat) {
  TerrainScenario scenario = testing::SmallScenario().terrain;
  scenario.trees_per_km2 = 400.0;
  const Terrain terrain(scenario);
  std::set<double> heights;
  for (double e = -900.0; e < 900.0; e += 13.7) {
    for (double n = -900.0; n < 900.0; n += 17.3) {
      const Eigen::Vector2d en(e, n);
      EXPECT_GE(terrain.Surface(en), terrain.Ground(en));
      EXPECT_LE(terrain.Surface(en), terrain.highest_m());
      EXPECT_GE(terrain.Ground(en), terrain.lowest_m());
      heights.insert(terrain.Ground(en));
    }
  }
  EXPECT_GT(*heights.rbegin() - *heights.begin(), 0.4 * scenario.relief_m);
  scenario.kind = TerrainKind::kFlat;
  scenario.base_m = 12.0;
  const Terrain flat(scenario);
  EXPECT_EQ(flat.Surface({123.0, -456.0}), 12.0);
}

struct Band {
  std::string name;
  double lowest_m, highest_m;  // above ground (paper, Table 1)
  std::size_t strip_pairs;
};

class ShippedScenarioManyRuns : public ::testing::TestWithParam<Band> {};

TEST_P(ShippedScenarioManyRuns, FliesAtItsHeightWithPairsInEveryOverlap) {
  Scenario scenario = ReadScenario(GetParam().name);
  scenario.imu.rate_hz = 10.0;  // path and pairs do not depend on this rate
  const SimulatedFlight flight = Simulate(scenario, {});
  const Terrain terrain(scenario.terrain);
  for (const StripInterval& strip : flight.strips) {
    for (double t_s = strip.t0_s; t_s < strip.t1_s; t_s += 0.5) {
      const Vector3d p_m = flight.truth->Pose(t_s).p_mb;
      const double above_m = p_m.z() - terrain.Ground(p_m.head<2>());
      EXPECT_GE(above_m, GetParam().lowest_m) << strip.name;
      EXPECT_LE(above_m, GetParam().highest_m) << strip.name;
    }
  }
  std::map<int, long> counts;
  for (const LidarPair& pair : flight.flight.pairs->pairs) ++counts[pair.file];
  EXPECT_EQ(counts.size(), GetParam().strip_pairs);
  for (const auto& [file, count] : counts) EXPECT_GE(count, 50) << file;
  EXPECT_EQ(static_cast<long>(flight.flight.pairs->pairs.size()), scenario.pairs.count);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenarioManyRuns,
                         ::testing::Values(Band{"leg2", 100, 200, 1}, Band{"leg4", 100, 200, 6},
                                           Band{"lar2", 150, 250, 1}, Band{"lar3", 150, 250, 3},
                                           Band{"uav2", 150, 250, 1}, Band{"uav3", 150, 250, 3},
                                           Band{"lar2_cross", 150, 250, 1},
                                           Band{"uav2_cross", 150, 250, 1},
                                           Band{"hal2", 2000, 2500, 1}),
                         [](const auto& band) { return band.param.name; });

}  // namespace dn::sim_test
