#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/lidar/strip_io.h>
#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <dn/sim/terrain.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "sim/small_scenario.h"
#include "sim/written_flight.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;

/// Returns SmallScenario with a second scanner whose scan plane leans 30 deg forward.
Scenario WithTwoScanners(const std::string& extra = "") {
  Scenario scenario = testing::SmallScenario(extra);
  scenario.lidar.name = "a";
  LidarScenario b = scenario.lidar;
  b.name = "b";
  b.gsd_m = 0.1;
  b.mounting.R_bs_nominal << 0.5, std::sqrt(0.75), 0.0, 0.0, 0.0, 1.0, std::sqrt(0.75), -0.5, 0.0;
  b.mounting.lever_arm_b_m = {0.32, 0.11, 0.18};
  b.mounting.boresight_rad = {0.004, 0.01, -0.006};
  scenario.more_scanners = {b};
  scenario.pairs.count = 60;
  scenario.pairs.between = 40;
  return scenario;
}

Vector3d ScannedGround(const SimulatedFlight& sim, double t_s, const Vector3d& u_s, int scanner) {
  Mounting mounting = ScannerAt(sim.flight.config, static_cast<std::size_t>(scanner)).mounting;
  mounting.boresight_rad = scanner == 0 ? sim.boresight_rad : sim.more_boresights_rad[0];
  mounting.lever_arm_b_m = scanner == 0 ? sim.lidar_lever_arm_b_m : sim.more_lever_arms_b_m[0];
  return Georeference(sim.truth->Pose(t_s), mounting, u_s);
}

TEST(SimulatedScanners, BothEndsOfEveryPairAreOneGroundPoint) {
  const SimulatedFlight sim = Simulate(WithTwoScanners(), {.noise = false});
  ASSERT_EQ(sim.flight.pairs->pairs.size(), 160u);
  int between = 0, of_one_strip = 0;
  for (const LidarPair& pair : sim.flight.pairs->pairs) {
    const Vector3d p_i = ScannedGround(sim, pair.t_i_s, pair.u_i_s, pair.scanner_i);
    const Vector3d p_j = ScannedGround(sim, pair.t_j_s, pair.u_j_s, pair.scanner_j);
    EXPECT_LT((p_i - p_j).norm(), 1e-5);
    EXPECT_GE(std::abs(pair.t_i_s - pair.t_j_s), 0.5);
    if (pair.scanner_i == pair.scanner_j) continue;
    ++between;
    if (std::abs(pair.t_i_s - pair.t_j_s) < 20.0) ++of_one_strip;
  }
  EXPECT_EQ(between, 40);
  EXPECT_GT(of_one_strip, 5);
}

TEST(SimulatedScanners, AreReadAsWritten) {
  const Scenario scenario = WithTwoScanners();
  const SimulatedFlight sim = Simulate(scenario, {.seed = 4});
  const Flight read = WrittenAndRead(sim);
  ASSERT_EQ(read.pairs->pairs.size(), sim.flight.pairs->pairs.size());
  for (std::size_t k = 0; k < read.pairs->pairs.size(); ++k) {
    const LidarPair &a = read.pairs->pairs[k], &b = sim.flight.pairs->pairs[k];
    EXPECT_EQ(a.scanner_i, b.scanner_i);
    EXPECT_EQ(a.scanner_j, b.scanner_j);
    EXPECT_EQ(a.t_j_s, b.t_j_s);
    EXPECT_EQ(a.u_j_s, b.u_j_s);
    ASSERT_EQ(a.covariance_m2.has_value(), b.covariance_m2.has_value());
    if (a.covariance_m2) {
      EXPECT_EQ(*a.covariance_m2, *b.covariance_m2);
    }
  }
  ASSERT_EQ(sim.flight.config.estimate.size(), 2u);
  EXPECT_EQ(sim.flight.config.estimate[1].unknown, read.config.estimate[1].unknown);
  EXPECT_EQ(ScannerAt(read.config, 1).sigma_p_m, 0.5 * read.config.lidar->sigma_p_m);
  EXPECT_THAT(FormatTruth(sim), HasSubstr("scanners:\n  - {name: \"a\", boresight_deg: ["));
}

TEST(SimulatedScanners, ScenariosAreReadAsWritten) {
  Scenario scenario = WithTwoScanners("effects: [{effect: lidar_range_offset, value: [0.1]}]\n");
  scenario.effects[0].scanner = "b";
  const std::string text = FormatScenario(scenario);
  const Scenario again = ParseScenario(text, "again.yaml");
  EXPECT_EQ(FormatScenario(again), text);
  EXPECT_EQ(again.more_scanners.size(), 1u);
  EXPECT_EQ(again.pairs.between, 40);
  const std::vector<Scenario> each = ScannerScenarios(again);
  ASSERT_EQ(each.size(), 2u);
  EXPECT_TRUE(each[0].effects.empty());
  EXPECT_EQ(each[1].effects.size(), 1u);
  EXPECT_EQ(each[1].pairs.sigma_p_m, 0.5 * each[0].pairs.sigma_p_m);
}

TEST(SimulatedScanners, AnEffectActsOnItsScanner) {
  Scenario scenario = WithTwoScanners("effects: [{effect: lidar_range_offset, value: [0.1]}]\n");
  scenario.effects[0].scanner = "b";
  const SimulatedFlight sim = Simulate(scenario, {.noise = false});
  for (const LidarPair& pair : sim.flight.pairs->pairs) {
    const Vector3d p_i = ScannedGround(sim, pair.t_i_s, pair.u_i_s, pair.scanner_i);
    const Vector3d p_j = ScannedGround(sim, pair.t_j_s, pair.u_j_s, pair.scanner_j);
    if (pair.scanner_i == 0 && pair.scanner_j == 0) {
      EXPECT_LT((p_i - p_j).norm(), 1e-5);
    }
    if (pair.scanner_i != pair.scanner_j) {
      EXPECT_NEAR((p_i - p_j).norm(), 0.1, 1e-5);
    }
  }
}

TEST(SimulatedScanners, OneNamedScannerGivesThePairsOfAMapping) {
  Scenario named = testing::SmallScenario();
  named.pairs.count = 40;
  const SimulatedFlight plain = Simulate(named, {.noise = false});
  named.lidar.name = "only";
  const SimulatedFlight listed = Simulate(named, {.noise = false});
  EXPECT_EQ(listed.flight.pairs->pairs.size(), plain.flight.pairs->pairs.size());
  EXPECT_EQ(listed.flight.config.lidar->name, "only");
  EXPECT_EQ(plain.flight.pairs->files[0].generic_string().substr(0, 6), "lidar/");
}

/// Two scanners with clouds and without pairs.
SimulatedFlight FlyTwoClouds(const std::string& extra = "", bool noise = false) {
  Scenario scenario = WithTwoScanners(extra);
  scenario.strips = true;
  scenario.pairs.count = 0;
  scenario.pairs.between = 0;
  scenario.lidar.pulse_rate_hz = scenario.more_scanners[0].pulse_rate_hz = 500.0;
  for (Effect& effect : scenario.effects) effect.scanner = "b";
  return Simulate(scenario, {.seed = 4, .noise = noise});
}

StripCloud FirstPoints(const std::filesystem::path& strip) {
  StripCloud points;
  EXPECT_TRUE(OpenStrip(strip)->Next(&points)) << strip;
  return points;
}

/// Writes the flight with its clouds.
void WriteAll(const SimulatedFlight& sim, const std::filesystem::path& folder) {
  OutputDirectory directory(folder);
  WriteFlight(sim, directory);
  EXPECT_EQ(WriteClouds(sim, 1, directory, {}).size(), 2 * sim.strips.size());
  directory.Commit();
}

TEST(SimulatedScanners, EachHasItsPointClouds) {
  const SimulatedFlight sim = FlyTwoClouds();
  const testing::TempFolder folder;
  WriteAll(sim, folder.path() / "flight");
  const FlightConfig config = ReadFlightConfig(folder.path() / "flight");
  EXPECT_EQ(NumScanners(config), 2u);
  const Terrain terrain(sim.scenario.terrain);
  for (int scanner = 0; scanner < 2; ++scanner) {
    const auto strips = FindStripFiles(config, static_cast<std::size_t>(scanner));
    ASSERT_EQ(strips.size(), sim.strips.size());
    const StripCloud points = FirstPoints(strips[1]);
    ASSERT_GT(points.size(), 100u);
    double on_surface = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const auto below = [&](double stretch) {
        const Vector3d p_m = ScannedGround(sim, points.t_s[k], stretch * points.u_s[k], scanner);
        return p_m.z() < terrain.Surface(p_m.head<2>());
      };
      if (!below(1.0 - 1e-4) && below(1.0 + 1e-4)) on_surface += 1.0;
    }
    EXPECT_GT(on_surface, 0.98 * static_cast<double>(points.size())) << "some hit edges";
  }
}

TEST(SimulatedScanners, CloudsHaveTheEffectsAndTheNoiseOfTheirScanner) {
  const SimulatedFlight exact = FlyTwoClouds();
  const SimulatedFlight spoilt =
      FlyTwoClouds("effects: [{effect: lidar_range_offset, value: [0.1]}]\n");
  const SimulatedFlight noisy = FlyTwoClouds("", true);
  const testing::TempFolder folder;
  WriteAll(exact, folder.path() / "exact");
  WriteAll(spoilt, folder.path() / "spoilt");
  WriteAll(noisy, folder.path() / "noisy");
  const auto points = [&](const std::string& flight, const std::string& scanner) {
    return FirstPoints(folder.path() / flight / ("strips_" + scanner) / "1.las");
  };
  EXPECT_EQ(points("exact", "a").u_s, points("spoilt", "a").u_s);
  const StripCloud before = points("exact", "b"), after = points("spoilt", "b");
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    ASSERT_NEAR(after.u_s[k].norm() - before.u_s[k].norm(), 0.1, 1e-9);
  }
  double same = 0.0;
  const StripCloud of_a = points("noisy", "a"), of_b = points("noisy", "b");
  const StripCloud exact_a = points("exact", "a");
  const std::size_t count = std::min({of_a.size(), of_b.size(), exact_a.size(), before.size()});
  for (std::size_t k = 0; k < count; ++k) {
    const double error_a = of_a.u_s[k].norm() - exact_a.u_s[k].norm();
    const double error_b = of_b.u_s[k].norm() - before.u_s[k].norm();
    same += std::abs(error_a - error_b) < 1e-6 ? 1.0 : 0.0;
  }
  EXPECT_LT(same, 0.1 * static_cast<double>(count)) << "both have the same noise";
}

}  // namespace dn::sim_test
