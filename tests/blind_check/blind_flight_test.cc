#include <dn/blind_check/blind_flight.h>
#include <dn/blind_check/blind_record.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "sim/small_scenario.h"

namespace dn::blind_check_test {

constexpr int kDrawn = 150;

BlindSuite Suite(std::uint64_t seed = 5) { return {seed, BlindScenarioNames()}; }

const std::vector<BlindFlight>& Drawn() {
  static const std::vector<BlindFlight> flights = [] {
    std::vector<BlindFlight> drawn;
    for (int k = 1; k <= kDrawn; ++k) drawn.push_back(DrawBlindFlight(Suite(), k));
    return drawn;
  }();
  return flights;
}

TEST(BlindFlight, IsMadeFromShippedScenariosAtRest) {
  std::set<std::string> bases;
  for (const BlindFlight& flight : Drawn()) bases.insert(flight.base);
  const std::vector<std::string> names = BlindScenarioNames();
  EXPECT_EQ(bases, std::set<std::string>(names.begin(), names.end()));
  EXPECT_TRUE(bases.contains("uav2_rest"));
}

TEST(BlindFlight, ItsContentHasTheStatedShares) {
  std::map<BlindContent, double> share;
  for (const BlindFlight& flight : Drawn()) share[flight.content()] += 1.0 / kDrawn;
  EXPECT_NEAR(share[BlindContent::kNothing], 0.2, 0.1);
  EXPECT_NEAR(share[BlindContent::kOneEffect], 0.5, 0.12);
  EXPECT_NEAR(share[BlindContent::kTwoEffects], 0.1, 0.08);
  EXPECT_NEAR(share[BlindContent::kUnlistedEffect], 0.2, 0.1);
}

TEST(BlindFlight, OfASuiteOfEffectsLeftOutHasOne) {
  BlindSuite suite = Suite();
  suite.only = BlindContent::kLeftOut;
  for (int number = 1; number <= 8; ++number) {
    const BlindFlight flight = DrawBlindFlight(suite, number);
    EXPECT_EQ(flight.content(), BlindContent::kLeftOut);
    EXPECT_EQ(flight.scenario.effects.size(), 1u);
    EXPECT_FALSE(flight.outsider.has_value());
  }
}

TEST(BlindFlight, OfASuiteOfOneContentHasThat) {
  for (const BlindContent content :
       {BlindContent::kNothing, BlindContent::kOneEffect, BlindContent::kTwoEffects,
        BlindContent::kThreeEffects, BlindContent::kUnlistedEffect}) {
    BlindSuite suite = Suite();
    suite.only = content;
    for (int number = 1; number <= 4; ++number) {
      EXPECT_EQ(DrawBlindFlight(suite, number).content(), content) << Word(content);
    }
    EXPECT_EQ(RecordContent(Word(content)), content);
  }
  EXPECT_THROW(RecordContent("everything"), InvalidInput);
}

TEST(BlindFlight, TakesTheChangesOfItsSuite) {
  BlindSuite suite = Suite();
  suite.changes = {"gnss.rate_hz=7"};
  const BlindFlight flight = DrawBlindFlight(suite, 3);
  EXPECT_EQ(flight.scenario.gnss.rate_hz, 7.0);
  EXPECT_NE(DrawBlindFlight(Suite(), 3).scenario.gnss.rate_hz, 7.0);
  EXPECT_EQ(flight.seed, DrawBlindFlight(Suite(), 3).seed);
}

TEST(BlindFlight, IsTheSameForTheSameSuiteAndNumber) {
  for (const int number : {1, 17}) {
    const BlindFlight flight = DrawBlindFlight(Suite(), number);
    const BlindFlight& again = Drawn()[static_cast<std::size_t>(number - 1)];
    EXPECT_EQ(flight.seed, again.seed);
    EXPECT_EQ(flight.base, again.base);
    EXPECT_EQ(flight.scenario.plan.lines.front().start_en_m,
              again.scenario.plan.lines.front().start_en_m);
    EXPECT_NE(DrawBlindFlight(Suite(6), number).seed, flight.seed);
  }
}

TEST(BlindFlight, EffectsAreOfTheTableAndNoFaults) {
  std::set<std::string> names;
  for (const BlindFlight& flight : Drawn()) {
    for (const Effect& effect : flight.scenario.effects) {
      const EffectSpec* spec = FindEffect(effect.name);
      ASSERT_NE(spec, nullptr) << effect.name;
      EXPECT_NE(spec->kind, EffectKind::kFault);
      EXPECT_EQ(ValueFault(*spec, effect.value), std::nullopt) << effect.name;
      EXPECT_EQ(effect.times.window_s.has_value(), spec->timing == EffectTiming::kWindow);
      EXPECT_EQ(effect.times.t0_s.has_value(), spec->timing == EffectTiming::kStart);
      names.insert(effect.name);
    }
  }
  EXPECT_GT(names.size(), 25U);
}

TEST(BlindFlight, TheSizeIsThatOfTheLargestComponent) {
  Effect effect;
  effect.name = "gnss_lever_arm";
  effect.value = {0.03, -0.12, 0.0};
  EXPECT_NEAR(DrawnSize(effect), 4.0, 1e-12);
  effect.name = "gnss_noise_scale";
  effect.value = {2.5};
  EXPECT_NEAR(DrawnSize(effect), 1.5, 1e-12);
  effect.name = "gyro_bias_process";
  effect.value = {0.6, 900.0};
  EXPECT_NEAR(DrawnSize(effect), 2.0, 1e-12) << "a correlation time does not count as a size";
  effect.name = "p2p_outliers";
  effect.value = {0.03, 20.0};
  EXPECT_NEAR(DrawnSize(effect), 1.0, 1e-12) << "the length of outliers does not count as a size";
}

TEST(BlindFlight, SizesAreOneToTenTimesTheUsualOne) {
  int small = 0, count = 0;
  for (const BlindFlight& flight : Drawn()) {
    for (const Effect& effect : flight.scenario.effects) {
      const EffectComponent& first = FindEffect(effect.name)->components.front();
      if (first.name == "ratio") {
        const double beyond = (effect.value[0] - 1.0) / (first.typical - 1.0);
        EXPECT_GE(beyond, 0.5 - 1e-9);
        EXPECT_LE(beyond, 4.0 + 1e-9);
        continue;
      }
      EXPECT_GE(DrawnSize(effect), 0.5);
      EXPECT_LE(DrawnSize(effect), 10.0 + 1e-9);
      small += DrawnSize(effect) < std::sqrt(10.0) ? 1 : 0;
      ++count;
    }
  }
  EXPECT_NEAR(static_cast<double>(small) / count, 0.55, 0.15) << "uniform in the logarithm";
}

TEST(BlindFlight, TheSizeFactorMultipliesAllSizes) {
  BlindSuite suite = Suite();
  suite.size_factor = 0.3;
  for (int number = 1; number <= 20; ++number) {
    const BlindFlight& usual = Drawn()[static_cast<std::size_t>(number - 1)];
    const BlindFlight weak = DrawBlindFlight(suite, number);
    ASSERT_EQ(weak.scenario.effects.size(), usual.scenario.effects.size());
    for (std::size_t k = 0; k < weak.scenario.effects.size(); ++k) {
      const Effect& effect = weak.scenario.effects[k];
      EXPECT_EQ(effect.name, usual.scenario.effects[k].name);
      EXPECT_NEAR(DrawnSize(effect), 0.3 * DrawnSize(usual.scenario.effects[k]), 1e-12)
          << effect.name;
    }
  }
}

TEST(BlindFlight, WindowsAndStartsLieBetweenTheStrips) {
  int checked = 0;
  for (const BlindFlight& flight : Drawn()) {
    for (const Effect& effect : flight.scenario.effects) {
      const auto& [window_s, t0_s] = effect.times;
      if (!window_s && !t0_s) continue;
      const FlightTimes times = PlannedTimes(flight.scenario, flight.seed);
      const double first_s = times.strips.front().t0_s, last_s = times.strips.back().t1_s;
      EXPECT_GE(window_s ? window_s->first : *t0_s, first_s);
      EXPECT_LE(window_s ? window_s->second : *t0_s, last_s);
      EXPECT_LT(window_s ? window_s->first : first_s, window_s ? window_s->second : last_s);
      ++checked;
    }
  }
  EXPECT_GT(checked, 5);
}

TEST(BlindFlight, LinesDiffer) {
  std::set<std::size_t> counts;
  double least = 1e9, most = 0.0;
  for (const BlindFlight& flight : Drawn()) {
    if (flight.base != "lar2_rest") continue;
    const std::vector<PlannedLine>& lines = flight.scenario.plan.lines;
    counts.insert(lines.size());
    const Eigen::Vector2d along = lines[0].end_en_m - lines[0].start_en_m;
    const double heading = std::atan2(along.x(), along.y());
    least = std::min(least, heading);
    most = std::max(most, heading);
  }
  EXPECT_EQ(counts, (std::set<std::size_t>{2, 3}));
  EXPECT_LT(least, -1.0);
  EXPECT_GT(most, 1.0);
}

TEST(BlindFlight, CanBeFlownWithPairsOfAllStrips) {
  for (const int number : {2, 9}) {
    Scenario scenario = Drawn()[static_cast<std::size_t>(number)].scenario;
    scenario.effects.clear();
    scenario.imu.rate_hz = 20.0;
    scenario.pairs.count = 100;
    const SimulatedFlight flown = Simulate(scenario, {});
    EXPECT_GE(flown.flight.pairs->files.size() + 1, flown.strips.size());
  }
}

TEST(UnlistedEffect, EachSpoilsItsSensorAlone) {
  const Scenario scenario = testing::SmallScenario();
  const FlightTimes times = PlannedTimes(scenario, 1);
  Random random(4, "outsiders");
  for (const std::string& name : UnlistedEffectNames()) {
    const UnlistedEffect outsider = DrawUnlistedEffect(name, times, random);
    EXPECT_EQ(outsider.name, name);
    const OwnErrors own = MakeOwnErrors(outsider, scenario);
    const int hooks = (own.gyro_radps ? 1 : 0) + (own.antenna_enu_m ? 1 : 0) +
                      (own.boresight_rad ? 1 : 0) + (own.laser_vector ? 1 : 0) +
                      (own.lidar_tag_shift_s ? 1 : 0) + (own.pairs ? 1 : 0);
    EXPECT_EQ(hooks, 1) << name;
    EXPECT_FALSE(FindEffect(name)) << "the table has an effect of this name";
  }
  EXPECT_THROW(MakeOwnErrors({"none", {}}, scenario), InvalidInput);
}

TEST(UnlistedEffect, ATorsionIsAlongTheScanAxisByAHarmonicOfTheAngle) {
  const Scenario scenario = testing::SmallScenario();
  const OwnErrors own = MakeOwnErrors(
      {"scan_torsion", {{"amplitude_deg", 0.05}, {"harmonic", 4}, {"phase_rad", 0.3}}}, scenario);
  const Eigen::Vector3d axis = scenario.lidar.scan_axis_s, nadir = scenario.lidar.nadir_axis_s;
  for (const double angle : {-0.5, 0.0, 0.2}) {
    const Eigen::Vector3d u = 300.0 * Eigen::AngleAxisd(angle, axis).toRotationMatrix() * nadir;
    const Eigen::Vector3d change = own.laser_vector(u, 0.0) - u;
    EXPECT_NEAR(change.dot(axis), 300.0 * 0.05 * M_PI / 180.0 * std::sin(4.0 * angle + 0.3), 1e-9);
    EXPECT_NEAR(change.cross(axis).norm(), 0.0, 1e-12);
  }
}

TEST(UnlistedEffect, AClockWalkIsContinuousAndStartsAtZero) {
  const Scenario scenario = testing::SmallScenario();
  const FlightTimes times = PlannedTimes(scenario, 1);
  Random random(4, "walk");
  const OwnErrors own =
      MakeOwnErrors(DrawUnlistedEffect("lidar_clock_walk", times, random), scenario);
  const double first_s = times.strips.front().t0_s, last_s = times.strips.back().t1_s;
  double largest = 0.0, before = own.lidar_tag_shift_s(first_s - 1.0);
  EXPECT_EQ(before, 0.0);
  for (double t_s = first_s - 1.0; t_s <= last_s; t_s += 0.01) {
    const double now = own.lidar_tag_shift_s(t_s);
    EXPECT_LT(std::abs(now - before), 2e-5);
    largest = std::max(largest, std::abs(now));
    before = now;
  }
  EXPECT_GT(largest, 2e-5);
}

TEST(UnlistedEffect, AWarmingBoresightIsZeroInTheMiddleOfTheStrips) {
  const Scenario scenario = testing::SmallScenario();
  const FlightTimes times = PlannedTimes(scenario, 1);
  Random random(4, "warming");
  const OwnErrors own =
      MakeOwnErrors(DrawUnlistedEffect("boresight_warming", times, random), scenario);
  MapPose pose;
  pose.t_s = 0.5 * (times.strips.front().t0_s + times.strips.back().t1_s);
  EXPECT_EQ(own.boresight_rad(pose).norm(), 0.0);
  const double middle_s = pose.t_s;
  pose.t_s = times.strips.front().t0_s;
  const double early = own.boresight_rad(pose).norm();
  pose.t_s = 2.0 * middle_s - pose.t_s;
  EXPECT_GT(early, 1.5 * own.boresight_rad(pose).norm()) << "the rate must decrease";
}

}  // namespace dn::blind_check_test
