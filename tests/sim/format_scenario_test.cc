#include <dn/error.h>
#include <dn/sim/simulate.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "sim/small_scenario.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

using ::testing::HasSubstr;
using testing::SmallScenario;
using testing::TempFolder;

SimulatedFlight FlyPlain(const Scenario& scenario) { return Simulate(scenario, {}); }

/// Expects identical measurements in both flights.
void ExpectSameFlight(const Flight& a, const Flight& b) {
  ASSERT_EQ(a.imu->samples.size(), b.imu->samples.size());
  for (std::size_t i = 0; i < a.imu->samples.size(); ++i) {
    ASSERT_EQ(a.imu->samples[i].w_ib_b_radps, b.imu->samples[i].w_ib_b_radps);
    ASSERT_EQ(a.imu->samples[i].f_b_mps2, b.imu->samples[i].f_b_mps2);
  }
  ASSERT_EQ(a.gnss->epochs.size(), b.gnss->epochs.size());
  for (std::size_t i = 0; i < a.gnss->epochs.size(); ++i) {
    ASSERT_EQ(a.gnss->epochs[i].p_m, b.gnss->epochs[i].p_m);
    ASSERT_EQ(a.gnss->epochs[i].velocity_enu_mps, b.gnss->epochs[i].velocity_enu_mps);
  }
  ASSERT_EQ(a.pairs->files, b.pairs->files);
  ASSERT_EQ(a.pairs->pairs.size(), b.pairs->pairs.size());
  for (std::size_t i = 0; i < a.pairs->pairs.size(); ++i) {
    ASSERT_EQ(a.pairs->pairs[i].t_i_s, b.pairs->pairs[i].t_i_s);
    ASSERT_EQ(a.pairs->pairs[i].u_j_s, b.pairs->pairs[i].u_j_s);
  }
  EXPECT_EQ(FormatFlightConfig(a.config), FormatFlightConfig(b.config));
}

/// Returns a scenario like SmallScenario, with every key different from its default.
Scenario OddScenario() {
  return ParseScenario(R"(
name: "odd \"name\""
origin_deg_m: [46.57, 6.52, 400.1]
start_s: 381000.5
plan:
  warm_up_s: 61
  lines: [[-500, 0, 500, 0, 200, 45], [500, 100, -500, 100, 210, 42]]
  bank_deg: 23
  turbulence: {roll_deg: 0.9, pitch_deg: 0.6, heading_deg: 0.5, speed_m_s: 0.8, height_m: 1.9,
               spectrum: dryden, wingspan_m: 7.7}
  crab_deg: 2.7
  stabilised_mount: true
  vibration:
    lines: [{frequency_hz: 7.3, accel_m_s2: [0.11, 0.2, 0.3], angle_urad: 3.7, harmonics: 2,
             wander_percent: 0.7}]
    resonances: [{frequency_hz: 4.1, damping: 0.07, accel_m_s2: 0.13, angle_urad: [1.1, 2.3, 0]}]
    broadband: [{low_hz: 1.7, high_hz: 9.1, accel_m_s2: 0.17, angle_urad: 0.9}]
terrain: {kind: mixed, base_m: -11, relief_m: 31, wavelength_m: 510, buildings_per_km2: 310,
          trees_per_km2: 210, roughness_m: 0.07, water_share: 0.03, seed: 5}
imu:
  rate_hz: 21
  sampling: instantaneous
  filter_hz: 9.3
  preset: ln200
  gyro: {white_deg_sqrt_h: 0.07, processes: [{type: random_walk, sigma_deg_h_sqrt_h: 0.1},
                                             {type: gauss_markov, sigma_deg_h: 1.7, tau_s: 33}]}
gnss: {rate_hz: 2.5, sigma_enu_m: [0.02, 0.03, 0.05], lever_arm_m: [0.4, -0.1, -1.1],
       velocity: true, processes: [{type: gauss_markov, sigma_enu_m: [0.01, 0.02, 0], tau_s: 77},
                   {type: gauss_markov, sigma_enu_m: [0.03, 0, 0], tau_s: 5, grows_with: bank}]}
lidar: {R_sensor_to_body: [[0,1,0],[0,0,1],[1,0,0]], scan_axis: [0,1,0], nadir_axis: [1,0,0],
        lever_arm_m: [0.14, -0.02, 0.21], boresight_deg: [0.8, -0.5, 1.2], fov_deg: 61,
        pattern: cone, gsd_m: 0.17, pulse_rate_hz: 77777, beam_divergence_mrad: 0.31,
        sigma_range_m: 0.013}
pairs: {count: 97, sigma_p_m: 0.051,
        shared_error: {fraction: 0.2, length_m: 45}}
strips: true
effects:
  - {effect: gnss_lever_arm, value: [0.1, 0, -0.03]}
  - {effect: imu_vibration, value: [0.1, 0.3], window_s: [381050, 381060]}
  - {effect: gnss_outage, window_s: [381060, 381063]}
  - {effect: boresight_step, value: [0.02, 0, 0.01], t0_s: 381090}
)",
                       "odd.yaml");
}

TEST(FormatScenario, EveryKeyIsReadBackToTheSameFlight) {
  const Scenario scenario = OddScenario();
  const std::string text = FormatScenario(scenario);
  SCOPED_TRACE(text);
  const Scenario again = ParseScenario(text, "again.yaml");
  EXPECT_EQ(again.name, scenario.name);
  EXPECT_EQ(again.lidar.pulse_rate_hz, scenario.lidar.pulse_rate_hz);
  EXPECT_EQ(again.lidar.beam_divergence_rad, scenario.lidar.beam_divergence_rad);
  EXPECT_EQ(again.lidar.sigma_range_m, scenario.lidar.sigma_range_m);
  EXPECT_EQ(again.terrain.roughness_m, scenario.terrain.roughness_m);
  EXPECT_EQ(again.terrain.water_share, scenario.terrain.water_share);
  EXPECT_TRUE(again.strips);
  ExpectSameFlight(FlyPlain(scenario).flight, FlyPlain(again).flight);
}

TEST(FormatScenario, WoodsAreReadBack) {
  Scenario scenario = OddScenario();
  scenario.terrain.kind = TerrainKind::kNatural;
  scenario.terrain.woods_share = 0.35;
  scenario.terrain.leaves = false;
  const Scenario again = ParseScenario(FormatScenario(scenario), "again.yaml");
  EXPECT_EQ(again.terrain.woods_share, 0.35);
  EXPECT_FALSE(again.terrain.leaves);
}

TEST(FormatScenario, KeysOfADetailedTerrainAreReadBack) {
  Scenario scenario = OddScenario();
  scenario.terrain.kind = TerrainKind::kForest;
  scenario.terrain.cars_per_km2 = 7.0;
  scenario.terrain.conifer_share = 0.3;
  scenario.terrain.leaves = false;
  scenario.lidar.pattern = ScanPattern::kZigzag;
  scenario.lidar.max_returns = 4;
  scenario.lidar.range_resolution_m = 1.7;
  scenario.lidar.noise_share = 0.003;
  scenario.lidar.scan_variation = 0.04;
  const Scenario again = ParseScenario(FormatScenario(scenario), "again.yaml");
  EXPECT_EQ(again.terrain.cars_per_km2, 7.0);
  EXPECT_EQ(again.terrain.conifer_share, 0.3);
  EXPECT_FALSE(again.terrain.leaves);
  EXPECT_EQ(again.lidar.pattern, ScanPattern::kZigzag);
  EXPECT_EQ(again.lidar.max_returns, 4);
  EXPECT_EQ(again.lidar.range_resolution_m, 1.7);
  EXPECT_EQ(again.lidar.noise_share, 0.003);
  EXPECT_EQ(again.lidar.scan_variation, 0.04);
}

TEST(FormatScenario, KeepsEveryShippedScenario) {
  for (const std::string& name : ScenarioNames()) {
    const Scenario scenario = ReadScenario(name);
    const std::string text = FormatScenario(scenario);
    const Scenario again = ParseScenario(text, name);
    EXPECT_EQ(FormatScenario(again), text) << name;
    EXPECT_EQ(again.imu.preset, scenario.imu.preset) << name;
    EXPECT_EQ(again.plan.lines.size(), scenario.plan.lines.size()) << name;
    EXPECT_EQ(again.effects.size(), scenario.effects.size()) << name;
  }
}

/// Returns a scenario that replays the flight in the folder.
Scenario Replay(const SimulatedFlight& flown, const TempFolder& folder) {
  folder.Write("flown.out", FormatSbet(flown.flight.reference->points()));
  Scenario scenario = SmallScenario();
  scenario.plan.replay = folder.path() / "flown.out";
  return scenario;
}

TEST(Replay, MeasuresOnTheNamedStrips) {
  const TempFolder folder;
  const SimulatedFlight flown = FlyPlain(SmallScenario());
  Scenario scenario = Replay(flown, folder);
  scenario.plan.strips = flown.strips;
  scenario.plan.strips[1].name = "back";
  const Scenario again =
      ParseScenario(FormatScenario(scenario), (folder.path() / "replay.yaml").string());
  const SimulatedFlight replayed = FlyPlain(again);
  ASSERT_EQ(replayed.strips.size(), 3u);
  EXPECT_EQ(replayed.strips[1].name, "back");
  EXPECT_EQ(replayed.strips[1].t0_s, flown.strips[1].t0_s);
  EXPECT_EQ(replayed.flight.pairs->files.front(), "lidar/1_3.txt");
  for (const LidarPair& pair : replayed.flight.pairs->pairs) {
    EXPECT_GE(pair.t_i_s, flown.strips.front().t0_s);
    EXPECT_LE(pair.t_j_s, flown.strips.back().t1_s);
  }
}

TEST(Replay, RefusesAStripThatIsNotFlown) {
  const TempFolder folder;
  Scenario scenario = Replay(FlyPlain(SmallScenario()), folder);
  scenario.plan.strips = {{"late", 500000.0, 500010.0}};
  try {
    FlyPlain(scenario);
    FAIL() << "no InvalidConfig";
  } catch (const InvalidConfig& error) {
    EXPECT_THAT(error.what(), HasSubstr("'late' lies outside"));
  }
}

TEST(Replay, StripsBelongToItAndHavePlainNames) {
  const auto fault = [](const std::string& plan) -> std::string {
    try {
      ParseScenario(
          "{name: x, origin_deg_m: [46, 7, 0], imu: {preset: airins}, lidar: {gsd_m: 1}, "
          "plan: {" +
              plan + "}}",
          "file.yaml");
    } catch (const InvalidConfig& error) {
      return error.what();
    }
    return "";
  };
  const std::string strip = "strips: [{name: 1, t0: 1, t1: 20}]";
  EXPECT_EQ(fault("replay: a.out, " + strip), "");
  EXPECT_THAT(fault("lines: [[0, 0, 1000, 0, 200, 40]], " + strip),
              HasSubstr("only allowed with replay"));
  EXPECT_THAT(fault("replay: a.out, strips: [{name: ../1, t0: 1, t1: 20}]"), HasSubstr("'../1'"));
  EXPECT_THAT(fault("replay: a.out, strips: [{name: 1, t0: 1, t1: 1}]"), HasSubstr("later"));
}

}  // namespace dn::sim_test
