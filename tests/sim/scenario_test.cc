#include <dn/error.h>
#include <dn/imu/imu_model.h>
#include <dn/sim/scenario.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "sim/small_scenario.h"
#include "testing/hostile_yaml.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

const std::string kGood = R"(name: x
origin_deg_m: [46, 7, 500]
start_s: 100
plan: {lines: [[0, 0, 1000, 0, 200, 40]]}
imu: {preset: airins}
lidar: {fov_deg: 60, gsd_m: 0.3}
)";

/// Returns the message of the InvalidConfig that the text causes; empty if it is valid.
std::string Fault(const std::string& yaml, long* line = nullptr) {
  try {
    ParseScenario(yaml, "file.yaml");
  } catch (const InvalidConfig& error) {
    EXPECT_EQ(error.where().file, "file.yaml");
    if (line != nullptr) *line = error.where().line;
    return error.what();
  }
  return "";
}

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ParseScenario, ConvertsToSiAndFillsDefaults) {
  const Scenario s = testing::SmallScenario();
  EXPECT_NEAR(s.origin.lat_rad, 46.57 * kRadPerDeg, 1e-15);
  EXPECT_EQ(s.origin.h_m, 400.0);
  EXPECT_EQ(s.plan.lines.size(), 3u);
  EXPECT_EQ(s.plan.lines[1].speed_mps, 42.0);
  EXPECT_NEAR(s.plan.bank_rad, 25.0 * kRadPerDeg, 1e-15);
  EXPECT_NEAR(s.plan.turbulence.pitch_rad, 0.7 * kRadPerDeg, 1e-15);
  EXPECT_NEAR(s.lidar.mounting.boresight_rad.z(), 1.2 * kRadPerDeg, 1e-15);
  EXPECT_EQ(s.lidar.mounting.R_bs_nominal(2, 0), 1.0);
  EXPECT_EQ(*s.imu.preset, "ln200");
  const Scenario d = ParseScenario(kGood, "file.yaml");
  EXPECT_NEAR(d.pairs.sigma_p_m, 0.3 / 2.0 / std::sqrt(3.0), 1e-15);
  EXPECT_EQ(d.plan.warm_up_s, 0.0);
  EXPECT_FALSE(d.plan.stabilised_mount);
}

TEST(ParseScenario, GroundIsRoughByItsKindUnderPointCloudsAlone) {
  const auto roughness_m = [](const std::string& more) {
    return ParseScenario(kGood + more, "file.yaml").terrain.roughness_m;
  };
  EXPECT_EQ(roughness_m("terrain: {kind: mountain}\n"), 0.0);
  EXPECT_EQ(roughness_m("terrain: {kind: mountain}\nstrips: true\n"), 0.3);
  EXPECT_EQ(roughness_m("terrain: {kind: built_up}\nstrips: true\n"), 0.03);
  EXPECT_EQ(roughness_m("terrain: {kind: natural, roughness_m: 0}\nstrips: true\n"), 0.0);
}

TEST(ParseScenario, ExplicitNoiseOverridesThePreset) {
  const Scenario s = ParseScenario(
      Replace(kGood, "imu: {preset: airins}",
              "imu:\n  preset: airins\n  gyro:\n    white_deg_sqrt_h: 0.06\n    processes:\n"
              "      - {type: random_walk, sigma_deg_h_sqrt_h: 0.1}\n"
              "      - {type: gauss_markov, sigma_deg_h: 2, tau_s: 50}\n"),
      "file.yaml");
  EXPECT_FALSE(s.imu.preset.has_value());
  EXPECT_NEAR(s.imu.model.gyro.white, 0.06 * kRadPerDeg / 60.0, 1e-15);
  ASSERT_EQ(s.imu.model.gyro.processes.size(), 2u);
  EXPECT_NEAR(s.imu.model.gyro.processes[0].sigma, 0.1 * kRadPerDeg / 3600.0 / 60.0, 1e-18);
  EXPECT_EQ(s.imu.model.gyro.processes[1].tau_s, 50.0);
  EXPECT_EQ(s.imu.model.accel.white, ImuPreset("airins").accel.white);
}

TEST(ParseScenario, ReportsErrorAndLocation) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  EXPECT_EQ(Fault(kGood), "");
  long line = 0;
  EXPECT_THAT(Fault(Replace(kGood, "fov_deg", "fov_dg"), &line),
              AllOf(HasSubstr("lidar: unknown key 'fov_dg'"), HasSubstr("'fov_deg'")));
  EXPECT_EQ(line, 6);
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0.3, pattern: con")),
              AllOf(HasSubstr("pattern"), HasSubstr("cone")));
  EXPECT_THAT(Fault(kGood + "pars: {}\n"), AllOf(HasSubstr("'pars'"), HasSubstr("'pairs'")));
  EXPECT_THAT(Fault(Replace(kGood, "airins", "airinz")), HasSubstr("airins"));
  EXPECT_THAT(Fault(kGood + "terrain: {kind: mixd}\n"), HasSubstr("mixed"));
  EXPECT_THAT(Fault(Replace(kGood, "name: x", "name: \"x\\n!y\"")), HasSubstr("control character"));
  EXPECT_THAT(Fault(Replace(kGood, "start_s: 100", "start_s: soon")), HasSubstr("start_s"));
  EXPECT_THAT(Fault(Replace(kGood, "start_s: 100", "start_s: .nan")), HasSubstr("start_s"));
  EXPECT_THAT(Fault(Replace(kGood, "start_s: 100", "start_s: 700000")), HasSubstr("week"));
  EXPECT_THAT(Fault(Replace(kGood, "[46, 7, 500]", "[96, 7, 500]")), HasSubstr("latitude"));
  EXPECT_THAT(Fault(Replace(kGood, ", 200, 40]]", ", 200]]")), HasSubstr("6 numbers"));
  EXPECT_THAT(Fault(Replace(kGood, ", 200, 40]]", ", 200, -4]]")), HasSubstr("speed"));
  EXPECT_THAT(Fault(Replace(kGood, "lines: [[0, 0, 1000, 0, 200, 40]]", "warm_up_s: 3")),
              HasSubstr("at least one line"));
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0")),
              HasSubstr("lidar.gsd_m: must be greater than 0"));
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0.3, nadir_axis: [0, 0, -1]")),
              HasSubstr("must point below the horizon"));
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0.3, nadir_axis: [1, 0, 0]")),
              HasSubstr("perpendicular"));
  EXPECT_THAT(Fault(Replace(kGood, "imu: {preset: airins}", "imu: {rate_hz: 200}")),
              HasSubstr("imu.preset"));
  EXPECT_THAT(Fault(kGood + "pairs: {count: 2.5}\n"), HasSubstr("an integer"));
  EXPECT_THAT(Fault(kGood + "strips: 3\n"), HasSubstr("strips"));
  EXPECT_THAT(Fault(kGood + "terrain: {relief_m: 10, water_share: 0.95}\n"),
              HasSubstr("terrain.water_share: must be at most 0.9"));
  EXPECT_THAT(Fault(kGood + "terrain: {water_share: 0.2}\n"), HasSubstr("water needs a relief"));
  EXPECT_THAT(Fault(kGood + "terrain: {kind: forest, conifer_share: 1.5}\n"),
              HasSubstr("conifer_share: must be at most 1"));
  EXPECT_THAT(Fault(kGood + "terrain: {kind: mixed, leaves: false}\n"),
              HasSubstr("only allowed on a terrain of kind forest"));
  EXPECT_THAT(Fault(kGood + "terrain: {kind: town, woods_share: 0.2}\n"),
              HasSubstr("woods_share: is only allowed on a terrain of kind mixed"));
  EXPECT_THAT(Fault(kGood + "terrain: {kind: natural, woods_share: 1.2}\n"),
              HasSubstr("woods_share: must be at most 1"));
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0.3, max_returns: 6")),
              HasSubstr("max_returns: must be at most 5"));
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0.3, noise_share: 0.01")),
              HasSubstr("needs max_returns of 2 or more"));
  EXPECT_THAT(Fault(kGood + "terrain: {roughness_m: 11}\n"),
              HasSubstr("terrain.roughness_m is 11"));
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0.3, sigma_range_m: -1")),
              HasSubstr("lidar.sigma_range_m"));
  EXPECT_THAT(Fault(Replace(kGood, "gsd_m: 0.3", "gsd_m: 0.3, pulse_rate_hz: 1e8")),
              HasSubstr("lidar.pulse_rate_hz is 1e+08"));
  EXPECT_THAT(Fault("name: [x\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(Fault("- 1\n"), HasSubstr("expected a map"));
  EXPECT_THAT(Fault(""), HasSubstr("is empty"));
  EXPECT_THAT(Fault(kGood + "name: y\n"), HasSubstr("given twice"));
  EXPECT_THAT(Fault(Replace(kGood, "name: x\n", "")), HasSubstr("name: expected a word"));
}

TEST(ParseScenario, RejectsScenariosTooLargeForMemory) {
  using ::testing::HasSubstr;
  const auto expect = [](const std::string& yaml, const std::string& what, long expected_line) {
    long line = 0;
    EXPECT_THAT(Fault(yaml, &line), HasSubstr(what));
    EXPECT_EQ(line, expected_line) << what;
  };
  expect(Replace(kGood, "plan: {", "plan: {warm_up_s: 604800, "), "plan.warm_up_s is 604800 s", 4);
  expect(Replace(kGood, "1000, 0, 200", "-2147483649, 0, 200"), "an end of plan.lines", 4);
  expect(Replace(kGood, "200, 40", "2147483649, 40"), "a height of plan.lines", 4);
  expect(kGood + "terrain: {base_m: 1e6}\n", "terrain.base_m", 7);
  expect(kGood + "terrain:\n  relief_m: 1e6\n", "terrain.relief_m", 8);
  expect(kGood + "pairs: {count: 6000000}\n", "pairs.count is 6e+06", 7);
  std::string effects, lines;
  for (int i = 0; i < 1001; ++i) {
    effects += "{}, ";
    lines += "[0, 0, 1000, 0, 200, 40], ";
  }
  expect(kGood + "effects: [" + effects + "]\n", "effects: has 1001 elements, at most 100", 7);
  expect(Replace(kGood, "lines: [", "lines: [" + lines), "at most 1000", 4);
}

TEST(ParseScenario, ChecksEffects) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  const auto with = [](const std::string& effect) { return kGood + "effects: [" + effect + "]\n"; };
  EXPECT_EQ(Fault(with("{effect: gnss_lever_arm, value: [0, 0, 1]}")), "");
  EXPECT_THAT(Fault(with("{effect: gnss_lever_am, value: [0, 0, 1]}")),
              HasSubstr("gnss_lever_arm"));
  EXPECT_THAT(Fault(with("{effect: gnss_lever_arm}")),
              HasSubstr("3 numbers (x [m], y [m], z [m])"));
  EXPECT_THAT(Fault(with("{effect: lidar_scan_cone, value: 60}")),
              AllOf(HasSubstr("effects[0].value: "), HasSubstr("between -45 and 45 deg, is 60")));
  EXPECT_THAT(Fault(with("{effect: imu_vibration, value: [1, 1]}")),
              AllOf(HasSubstr("window_s"), HasSubstr("is missing")));
  EXPECT_THAT(Fault(with("{effect: imu_gap, window_s: [5, 5]}")), HasSubstr("begin before end"));
  EXPECT_THAT(Fault(with("{effect: imu_gap, value: 1, window_s: [5, 6]}")), HasSubstr("no value"));
  EXPECT_EQ(Fault(with("{effect: gnss_clock_step, value: 1, t0_s: 5}")), "");
  EXPECT_THAT(Fault(with("{effect: gnss_clock_step, value: 1}")), HasSubstr("t0_s"));
  EXPECT_THAT(Fault(with("{effect: p2p_outliers, value: [1.2, 1]}")), HasSubstr("share"));
  EXPECT_THAT(Fault(with("{effect: gyro_bias_process, value: [1, 0]}")), HasSubstr("positive"));
  EXPECT_THAT(Fault(with("{effect: gnss_noise_scale, value: 0}")), HasSubstr("positive"));
  EXPECT_THAT(Fault(with("{effect: gnss_lever_arm, value: [0, 1]}")), HasSubstr("3 numbers"));
  EXPECT_THAT(Fault(with("{effect: lidar_time_offset, value: [0, 1]}")), HasSubstr("1 number"));
  EXPECT_THAT(Fault(with("{effect: lidar_time_offset, value: 1, t0_s: 3}")), HasSubstr("t0_s"));
  EXPECT_THAT(Fault(with("{effect: imu_vibration, value: [1, -1], window_s: [5, 6]}")),
              HasSubstr("sigma accel must not be negative"));
}

const std::string kEveryKey = R"(name: x
origin_deg_m: [46, 7, 500]
start_s: 100
plan:
  warm_up_s: 10
  lines: [[0, 0, 1000, 0, 200, 40]]
  bank_deg: 25
  turbulence: {roll_deg: 1, pitch_deg: 1, heading_deg: 1, speed_m_s: 1, height_m: 1}
  crab_deg: 3
  stabilised_mount: false
terrain: {kind: mixed, relief_m: 6, wavelength_m: 900, base_m: 0, buildings_per_km2: 3,
          trees_per_km2: 0, roughness_m: 0.1, water_share: 0.1, seed: 1}
imu: {rate_hz: 100, preset: airins, gyro: {white_deg_sqrt_h: 0.1, processes: [{type: gauss_markov,
      sigma_deg_h: 1, tau_s: 3}]}, accel: {white_m_s_sqrt_h: 0.1, processes: []}}
gnss: {rate_hz: 1, sigma_enu_m: [0.1, 0.1, 0.1], lever_arm_m: [1, 0, 0], velocity: false}
lidar: {R_sensor_to_body: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], scan_axis: [1, 0, 0],
        nadir_axis: [0, 0, 1], lever_arm_m: [0, 0, 0], boresight_deg: [0, 0, 0], fov_deg: 60,
        pattern: cone, pulse_rate_hz: 1000, gsd_m: 0.3, beam_divergence_mrad: 0.3,
        sigma_range_m: 0.02}
pairs: {count: 30, sigma_p_m: 0.1}
strips: false
effects: [{effect: imu_vibration, value: [1, 1], window_s: [110, 120]},
          {effect: gnss_clock_step, value: 1, t0_s: 110}]
)";

TEST(ParseScenario, HostileValuesAreReadOrRejectedWithLocation) {
  const auto parse = [](const std::string& document) { ParseScenario(document, "file.yaml"); };
  ASSERT_NO_THROW(parse(kEveryKey));
  EXPECT_GT(testing::CountRefused(kEveryKey, parse), 1500);
}

TEST(ParseScenario, AMissingSectionHasThePlaceOfItsMap) {
  long line = 0;
  Fault(Replace(kGood, "imu: {preset: airins}\n", ""), &line);
  EXPECT_EQ(line, 1);
}

TEST(ReadScenario, RejectsFilesThatAreNotRegular) {
  const testing::TempFolder folder;
  const std::string pipe = (folder.path() / "pipe.yaml").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto message = [](const std::string& name) -> std::string {
    try {
      ReadScenario(name);
    } catch (const InvalidConfig& error) {
      EXPECT_EQ(error.where().file, name);
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(pipe), ::testing::HasSubstr("a named pipe, not a regular file"));
  EXPECT_THAT(message(folder.path().string()), ::testing::HasSubstr("a folder, not a regular"));
  EXPECT_THAT(message("/dev/zero"), ::testing::HasSubstr("a device, not a regular file"));
  folder.Write("large.yaml", std::string(2000000, '#'));
  EXPECT_THAT(message((folder.path() / "large.yaml").string()),
              ::testing::HasSubstr("at most 1048576 are read"));
}

bool SameModel(const SensorNoise& a, const SensorNoise& b) {
  const auto same = [](const BiasProcess& p, const BiasProcess& q) {
    return p.type == q.type && p.sigma == q.sigma && p.tau_s == q.tau_s;
  };
  return a.white == b.white && std::equal(a.processes.begin(), a.processes.end(),
                                          b.processes.begin(), b.processes.end(), same);
}

/// Strip set and the preset of its sensor.
struct StripSet {
  std::string name, preset;
};

class StripSetVariants : public ::testing::TestWithParam<StripSet> {};

TEST_P(StripSetVariants, DifferFromTheFlightOnlyInNoiseAndEffects) {
  const auto& [name, preset] = GetParam();
  const Scenario flown = ReadScenario(name);
  const ImuModel at_rest = ImuPreset(preset);
  EXPECT_FALSE(flown.imu.preset) << "noise of flight beyond the preset";
  EXPECT_FALSE(SameModel(flown.imu.model.accel, at_rest.accel));
  EXPECT_TRUE(flown.effects.empty());
  for (const std::string& variant : {name + "_rest", name + "_effects"}) {
    const Scenario s = ReadScenario(variant);
    EXPECT_EQ(s.imu.preset, preset);
    EXPECT_EQ(s.imu.rate_hz, flown.imu.rate_hz);
    EXPECT_TRUE(SameModel(s.imu.model.gyro, at_rest.gyro));
    EXPECT_TRUE(SameModel(s.imu.model.accel, at_rest.accel));
    EXPECT_EQ(s.start_s, flown.start_s);
    EXPECT_EQ(s.plan.warm_up_s, flown.plan.warm_up_s);
    EXPECT_EQ(s.plan.lines.size(), flown.plan.lines.size());
    EXPECT_EQ(s.gnss.lever_arm_b_m, flown.gnss.lever_arm_b_m);
    EXPECT_EQ(s.lidar.pattern, flown.lidar.pattern);
    EXPECT_EQ(s.lidar.mounting.boresight_rad, flown.lidar.mounting.boresight_rad);
    EXPECT_EQ(s.pairs.count, flown.pairs.count);
  }
  EXPECT_TRUE(ReadScenario(name + "_rest").effects.empty());
  std::vector<std::string> effects;
  for (const Effect& effect : ReadScenario(name + "_effects").effects) {
    effects.push_back(effect.name);
    if (effect.name != "imu_vibration") continue;
    EXPECT_LE(effect.times.window_s->first, flown.start_s);
    EXPECT_GE(effect.times.window_s->second, flown.start_s + 3600.0) << "the whole flight";
  }
  EXPECT_THAT(effects,
              ::testing::IsSupersetOf({"imu_vibration", "accel_bias_process", "gyro_scale_factor",
                                       "accel_scale_factor", "gyro_misalignment", "gravity_tilt"}));
}

INSTANTIATE_TEST_SUITE_P(All, StripSetVariants,
                         ::testing::Values(StripSet{"leg2", "ln200"}, StripSet{"leg4", "ln200"},
                                           StripSet{"lar2", "airins"}, StripSet{"lar3", "airins"},
                                           StripSet{"uav2", "apx15"}, StripSet{"uav3", "apx15"},
                                           StripSet{"har2", "imu57"}, StripSet{"har4", "imu57"},
                                           StripSet{"hal2", "isa100c"},
                                           StripSet{"hal4", "isa100c"}),
                         [](const auto& set) { return set.param.name; });

TEST(ReadScenario, DocumentedScenarioHasEveryKey) {
  const Scenario shown = ReadScenario(std::string(DN_REFERENCE_DIR) + "/scenario.yaml");
  const Scenario lar3 = ReadScenario("lar3_rest");
  EXPECT_EQ(shown.imu.preset, lar3.imu.preset);
  EXPECT_EQ(shown.plan.lines.size(), lar3.plan.lines.size());
  EXPECT_EQ(shown.effects.size(), 2u);
  const std::string text = ScenarioText(std::string(DN_REFERENCE_DIR) + "/scenario.yaml");
  const std::set<std::string> elsewhere{
      "white_deg_sqrt_h", "white_m_s_sqrt_h", "processes", "type", "sigma_deg_h", "tau_s", "t0_s"};
  const std::regex key("([A-Za-z0-9_]+):");
  for (std::sregex_iterator it(kEveryKey.begin(), kEveryKey.end(), key), end; it != end; ++it) {
    if (elsewhere.contains((*it)[1])) continue;
    EXPECT_THAT(text, ::testing::HasSubstr((*it)[0].str()));
  }
}

TEST(ReadScenario, FindsShippedScenariosAndFiles) {
  EXPECT_THAT(ScenarioNames(),
              ::testing::ElementsAre(
                  "leg2", "leg4", "lar2", "lar3", "uav2", "uav3", "har2", "har4", "hal2", "hal4",
                  "lar2_cross", "uav2_cross", "leg2_rest", "leg4_rest", "lar2_rest", "lar3_rest",
                  "uav2_rest", "uav3_rest", "har2_rest", "har4_rest", "hal2_rest", "hal4_rest",
                  "leg2_effects", "leg4_effects", "lar2_effects", "lar3_effects", "uav2_effects",
                  "uav3_effects", "har2_effects", "har4_effects", "hal2_effects", "hal4_effects"));
  for (const std::string& name : ScenarioNames()) EXPECT_EQ(ReadScenario(name).name, name);
  const testing::TempFolder folder;
  folder.Write("mine.yaml", Replace(kGood, "lines: [[0, 0, 1000, 0, 200, 40]]", "replay: a.out"));
  const Scenario mine = ReadScenario((folder.path() / "mine.yaml").string());
  EXPECT_EQ(*mine.plan.replay, folder.path() / "a.out");
  const auto message = [](const std::string& name) -> std::string {
    try {
      ReadScenario(name);
    } catch (const InvalidConfig& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("lar33"), ::testing::HasSubstr("lar3"));
}

}  // namespace dn::sim_test
