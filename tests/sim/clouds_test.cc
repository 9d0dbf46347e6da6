#include <dn/geo/read_file.h>
#include <dn/lidar/mounting.h>
#include <dn/lidar/strip_io.h>
#include <dn/sim/simulate.h>
#include <dn/sim/terrain.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "small_scenario.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kOnSurface_m = 1e-6;

Scenario CloudScenario(const std::string& extra = "") {
  Scenario scenario = testing::SmallScenario("strips: true\n" + extra);
  scenario.pairs.count = 0;
  scenario.lidar.pulse_rate_hz = 1500.0;
  return scenario;
}

SimulatedFlight FlyClouds(const Scenario& scenario, bool noise = false) {
  return Simulate(scenario, {.seed = 5, .noise = noise});
}

/// Returns all points of a strip.
StripCloud AllPoints(const SimulatedFlight& flight, std::size_t strip, int threads = 2) {
  StripCloud all;
  flight.clouds->Run(
      strip, threads,
      [&](const StripCloud& some) {
        all.t_s.insert(all.t_s.end(), some.t_s.begin(), some.t_s.end());
        all.u_s.insert(all.u_s.end(), some.u_s.begin(), some.u_s.end());
        all.p_c.insert(all.p_c.end(), some.p_c.begin(), some.p_c.end());
        all.source.insert(all.source.end(), some.source.begin(), some.source.end());
      },
      nullptr);
  return all;
}

Mounting TrueMounting(const SimulatedFlight& flight) {
  Mounting mounting = flight.scenario.lidar.mounting;
  mounting.lever_arm_b_m = flight.lidar_lever_arm_b_m;
  return mounting;
}

/// Returns the number of points on the surface. They are compared along their rays, so that points
/// on walls count too.
std::size_t CountOnSurface(const SimulatedFlight& flight, const StripCloud& points,
                           const std::function<Mounting(double t_s)>& mounting, double late_s = 0) {
  const Terrain terrain(flight.scenario.terrain);
  const auto above_m = [&](const Vector3d& p_m) {
    return p_m.z() - terrain.Surface(p_m.head<2>());
  };
  std::size_t on_surface = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t_s = points.t_s[i] - late_s;
    const MapPose pose = flight.truth->Pose(t_s);
    const Mounting sensor = mounting(t_s);
    const Vector3d step_s = kOnSurface_m * points.u_s[i].normalized();
    const bool reached = above_m(Georeference(pose, sensor, points.u_s[i] + step_s)) <= 0.0;
    const bool too_far = above_m(Georeference(pose, sensor, points.u_s[i] - step_s)) < 0.0;
    if (reached && !too_far) ++on_surface;
  }
  return on_surface;
}

TEST(Clouds, ExactPointsLieOnTheSurface) {
  for (const ScanPattern pattern : {ScanPattern::kLine, ScanPattern::kCone}) {
    Scenario scenario =
        CloudScenario("effects: [{effect: lidar_lever_arm, value: [0.3, -0.2, 0.1]}]\n");
    scenario.lidar.pattern = pattern;
    const SimulatedFlight flight = FlyClouds(scenario);
    const StripCloud points = AllPoints(flight, 2);
    EXPECT_GT(points.size(), 30000u);
    EXPECT_EQ(CountOnSurface(flight, points, [&](double) { return TrueMounting(flight); }),
              points.size());
  }
}

TEST(Clouds, PointsAreMadeWithTheAssumedMounting) {
  const SimulatedFlight flight = FlyClouds(CloudScenario());
  const StripCloud points = AllPoints(flight, 0);
  const Mounting assumed = flight.flight.config.lidar->mounting;
  EXPECT_EQ(assumed.boresight_rad, Vector3d::Zero());
  for (std::size_t i = 0; i < points.size(); i += 100) {
    const Vector3d p_m = Georeference(flight.truth->Pose(points.t_s[i]), assumed, points.u_s[i]);
    EXPECT_LT((points.p_c[i] - p_m).norm(), kOnSurface_m);
  }
}

/// Returns a scenario with flat terrain and a calm, level flight; the pulses are gsd_m apart.
Scenario FlatScenario(ScanPattern pattern, double gsd_m) {
  constexpr double kFov_rad = 1.0, kSpeed_mps = 40.0, kHeight_m = 200.0;
  Scenario scenario = CloudScenario();
  scenario.plan.turbulence = {};
  scenario.plan.crab_rad = 0.0;
  scenario.plan.lines = {{{-150.0, 0.0}, {150.0, 0.0}, kHeight_m, kSpeed_mps}};
  scenario.terrain = {};
  scenario.terrain.kind = TerrainKind::kFlat;
  scenario.lidar.mounting.boresight_rad.setZero();
  scenario.lidar.pattern = pattern;
  scenario.lidar.fov_rad = kFov_rad;
  const double scan_m = pattern == ScanPattern::kLine
                            ? kHeight_m * kFov_rad
                            : 2.0 * std::numbers::pi * kHeight_m * std::tan(0.5 * kFov_rad);
  scenario.lidar.pulse_rate_hz = kSpeed_mps * scan_m / (gsd_m * gsd_m);
  return scenario;
}

double DensityNearTrack(const StripCloud& points) {
  constexpr double kHalf_m = 10.0;
  const auto near = [](const Vector3d& p_m) {
    return p_m.head<2>().cwiseAbs().maxCoeff() < kHalf_m;
  };
  const auto count = std::count_if(points.p_c.begin(), points.p_c.end(), near);
  return static_cast<double>(count) / (4.0 * kHalf_m * kHalf_m);
}

/// Returns the mean distance of neighbouring points in a scan, near the track.
double SpacingAcross(const StripCloud& points) {
  double sum_m = 0.0;
  int count = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double apart_m = (points.p_c[i] - points.p_c[i - 1]).norm();
    if (std::abs(points.p_c[i].y()) > 10.0 || apart_m > 10.0) continue;
    sum_m += apart_m;
    ++count;
  }
  return sum_m / count;
}

TEST(Clouds, LinePulsesAreOneGsdApartAlongAndAcross) {
  constexpr double kGsd_m = 0.5;
  const StripCloud points = AllPoints(FlyClouds(FlatScenario(ScanPattern::kLine, kGsd_m)), 0);
  EXPECT_NEAR(DensityNearTrack(points) * kGsd_m * kGsd_m, 1.0, 0.05);
  EXPECT_NEAR(SpacingAcross(points), kGsd_m, 0.05 * kGsd_m);
}

TEST(Clouds, AConeSeesTheGroundTwice) {
  constexpr double kGsd_m = 0.5;
  const StripCloud points = AllPoints(FlyClouds(FlatScenario(ScanPattern::kCone, kGsd_m)), 0);
  EXPECT_NEAR(DensityNearTrack(points) * kGsd_m * kGsd_m, 2.0, 0.1);
  EXPECT_NEAR(SpacingAcross(points), kGsd_m, 0.1 * kGsd_m);
}

TEST(Clouds, NoiseMatchesTheScenario) {
  Scenario scenario = FlatScenario(ScanPattern::kLine, 1.0);
  scenario.lidar.sigma_range_m = 0.05;
  scenario.lidar.beam_divergence_rad = 4e-3;
  const SimulatedFlight flight = FlyClouds(scenario, true);
  const StripCloud points = AllPoints(flight, 0);
  double squares = 0.0, expected = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d u_s = points.u_s[i];
    const Vector3d p_m = Georeference(flight.truth->Pose(points.t_s[i]), TrueMounting(flight), u_s);
    const double cosine = u_s.x() / u_s.norm(), sine = std::sqrt(1.0 - cosine * cosine);
    squares += p_m.z() * p_m.z();
    expected += std::pow(0.05 * cosine, 2) + std::pow(1e-3 * u_s.norm() * sine, 2);
  }
  EXPECT_NEAR(squares / expected, 1.0, 0.05);
}

TEST(Clouds, NoiseOfAStripDependsOnlyOnItsName) {
  Scenario scenario = FlatScenario(ScanPattern::kLine, 1.0);
  const StripCloud before = AllPoints(FlyClouds(scenario, true), 0);
  scenario.pairs.count = 0;
  scenario.gnss.rate_hz = 5.0;
  scenario.plan.lines.push_back({{150.0, 50.0}, {-150.0, 50.0}, 200.0, 40.0});
  const StripCloud after = AllPoints(FlyClouds(scenario, true), 0);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); i += 50) {
    EXPECT_LT((after.u_s[i] - before.u_s[i]).norm(), kOnSurface_m);
  }
}

TEST(Clouds, AreSortedByTimeAndIndependentOfThreads) {
  const SimulatedFlight flight = FlyClouds(CloudScenario(), true);
  const testing::TempFolder folder;
  const auto written = [&](const std::string& name, int threads) {
    const CloudCounts counts = flight.clouds->Write(1, folder.path() / name, threads, nullptr);
    EXPECT_EQ(counts.points, counts.pulses);
    return ReadWholeFile(folder.path() / name);
  };
  const std::string one = written("one.las", 1);
  EXPECT_EQ(one, written("two.las", 2));

  const StripCloud points = AllPoints(flight, 1);
  EXPECT_TRUE(std::is_sorted(points.t_s.begin(), points.t_s.end()));
  const auto reader = OpenStrip(folder.path() / "one.las");
  ASSERT_EQ(reader->points(), points.size());
  std::size_t i = 0;
  for (StripCloud read; reader->Next(&read);) {
    for (std::size_t k = 0; k < read.size(); ++k, ++i) {
      ASSERT_EQ(read.t_s[k], points.t_s[i]);
      ASSERT_EQ(read.u_s[k], points.u_s[i]);
      ASSERT_LT((read.p_c[k] - points.p_c[i]).norm(), 1e-4);
      ASSERT_EQ(read.source[k], 2);
    }
  }
}

TEST(Clouds, VectorsContainTheLidarEffects) {
  const Scenario scenario = CloudScenario();
  const StripCloud plain = AllPoints(FlyClouds(scenario), 0);
  const StripCloud longer = AllPoints(
      FlyClouds(CloudScenario("effects: [{effect: lidar_range_offset, value: 0.25}]\n")), 0);
  const SimulatedFlight late_flight =
      FlyClouds(CloudScenario("effects: [{effect: lidar_time_offset, value: 0.01}]\n"));
  const StripCloud late = AllPoints(late_flight, 0);
  ASSERT_EQ(longer.size(), plain.size());
  ASSERT_EQ(late.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); i += 100) {
    EXPECT_NEAR(longer.u_s[i].norm() - plain.u_s[i].norm(), 0.25, 1e-9);
    EXPECT_EQ(late.u_s[i], plain.u_s[i]);
    EXPECT_NEAR(late.t_s[i] - plain.t_s[i], 0.01, 1e-9);
    const Vector3d p_m = Georeference(late_flight.truth->Pose(late.t_s[i]),
                                      late_flight.flight.config.lidar->mounting, late.u_s[i]);
    EXPECT_LT((late.p_c[i] - p_m).norm(), kOnSurface_m);
  }
}

TEST(Clouds, ABoresightStepTurnsTheBeams) {
  Scenario scenario = CloudScenario();
  const double step_at_s = [&] {
    const StripInterval strip = PlannedTimes(scenario, 5).strips[0];
    return 0.5 * (strip.t0_s + strip.t1_s);
  }();
  scenario.effects = CloudScenario("effects: [{effect: boresight_step, value: [0.5, 0, 0], t0_s: " +
                                   std::to_string(step_at_s) + "}]\n")
                         .effects;
  const SimulatedFlight flight = FlyClouds(scenario);
  const StripCloud points = AllPoints(flight, 0);
  const Mounting before = TrueMounting(flight);
  Mounting after = before;
  after.boresight_rad.x() += 0.5 * kRadPerDeg;
  const double at_s = scenario.effects[0].times.t0_s.value();
  const auto stepped = [&](double t_s) { return t_s < at_s ? before : after; };
  EXPECT_EQ(CountOnSurface(flight, points, stepped), points.size());
  EXPECT_LT(CountOnSurface(flight, points, [&](double) { return TrueMounting(flight); }),
            points.size() * 6 / 10);
}

TEST(Clouds, WaterIsAGap) {
  Scenario scenario = CloudScenario();
  scenario.terrain.buildings_per_km2 = 0.0;
  scenario.terrain.water_share = 0.3;
  const SimulatedFlight flight = FlyClouds(scenario);
  const Terrain terrain(scenario.terrain);
  const CloudCounts counts = flight.clouds->Run(
      0, 1,
      [&](const StripCloud& cloud) {
        for (std::size_t i = 0; i < cloud.size(); ++i) {
          const Vector3d p_m =
              Georeference(flight.truth->Pose(cloud.t_s[i]), TrueMounting(flight), cloud.u_s[i]);
          EXPECT_FALSE(terrain.Water(p_m.head<2>()) &&
                       terrain.Water(p_m.head<2>() + Vector2d(1e-3, 1e-3)));
        }
      },
      nullptr);
  EXPECT_GT(counts.on_water, counts.pulses / 20);
  EXPECT_EQ(counts.points + counts.on_water, counts.pulses);
}

TEST(Clouds, ExistOnlyIfTheScenarioAsks) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 0;
  EXPECT_EQ(FlyClouds(scenario).clouds, nullptr);
}

}  // namespace dn::sim_test
