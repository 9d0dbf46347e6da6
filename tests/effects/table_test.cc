#include <dn/effects/effect_table.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace dn::effects_test {

using ::testing::HasSubstr;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

std::string Fault(const std::string& name, const std::vector<double>& value) {
  return ValueFault(*FindEffect(name), value).value_or("");
}

TEST(EffectTable, NamesAreUniqueAndFound) {
  std::set<std::string> names;
  for (const EffectSpec& effect : EffectTable()) {
    EXPECT_TRUE(names.insert(effect.name).second) << effect.name;
    EXPECT_EQ(FindEffect(effect.name), &effect);
  }
  EXPECT_EQ(FindEffect("gnss_lever_am"), nullptr);
  EXPECT_EQ(EffectNames().size(), names.size());
  EXPECT_THAT(EffectNames(EffectKind::kFault),
              ::testing::ElementsAre("trajectory_attitude_offset", "gnss_outage", "gnss_clock_step",
                                     "imu_gap", "imu_clock_step"));
}

TEST(EffectTable, EveryTypicalSizeIsAllowedAndNotZero) {
  for (const EffectSpec& effect : EffectTable()) {
    std::vector<double> typical;
    for (const EffectComponent& part : effect.components) {
      EXPECT_GT(part.typical, 0.0) << effect.name;
      EXPECT_GT(part.to_si, 0.0) << effect.name;
      typical.push_back(part.typical);
    }
    EXPECT_EQ(ValueFault(effect, typical), std::nullopt) << effect.name;
  }
}

// An unknown of the adjustment is one block with one unit and can have either sign.
TEST(EffectTable, AFixedEffectHasOneUnitAndBothSigns) {
  for (const EffectSpec& effect : EffectTable()) {
    if (effect.kind != EffectKind::kFixed) continue;
    ASSERT_FALSE(effect.components.empty()) << effect.name;
    for (const EffectComponent& part : effect.components) {
      EXPECT_EQ(part.unit, effect.components.front().unit) << effect.name;
      EXPECT_LT(part.lowest, 0.0) << effect.name;
      EXPECT_GT(part.highest, 0.0) << effect.name;
    }
  }
}

TEST(EffectTable, ConvertsToSi) {
  const auto si = [](const char* name, const std::vector<double>& value) {
    return ValueInSi(*FindEffect(name), value);
  };
  EXPECT_NEAR(si("gyro_scale_factor", {0, 0, 500})[2], 5e-4, 1e-18);
  EXPECT_NEAR(si("gyro_g_sensitivity", {2, 0, 0})[0] * 9.80665, 2.0 * kRadPerDeg / 3600.0, 1e-20);
  EXPECT_NEAR(si("accel_bias_process", {3, 7})[0], 3e-3 * 9.80665, 1e-16);
  EXPECT_EQ(si("accel_bias_process", {3, 7})[1], 7.0);
  EXPECT_NEAR(si("gravity_tilt", {3600, 0})[0], kRadPerDeg, 1e-16);
  EXPECT_NEAR(si("gravity_disturbance", {20})[0], 20e-5, 1e-18);
  EXPECT_NEAR(si("boresight_drift", {0, 0.5, 0})[1], 0.5 * kRadPerDeg / 3600.0, 1e-20);
  EXPECT_NEAR(si("accel_misalignment", {1, 0, 0})[0], 1e-3, 1e-18);
  EXPECT_NEAR(si("p2p_range_noise", {0.3})[0], 3e-4, 1e-18);
}

TEST(EffectTable, ConvertsTypicalSizesToSi) {
  for (const EffectSpec& effect : EffectTable()) {
    std::vector<double> typical;
    for (const EffectComponent& component : effect.components) typical.push_back(component.typical);
    EXPECT_EQ(TypicalInSi(effect), ValueInSi(effect, typical)) << effect.name;
  }
}

TEST(EffectTable, ReportsTheErrorInAValue) {
  EXPECT_EQ(Fault("gnss_lever_arm", {0, 0, -1}), "");
  EXPECT_EQ(Fault("gnss_lever_arm", {0, 1}),
            "'gnss_lever_arm' takes 3 numbers (x [m], y [m], z [m])");
  EXPECT_EQ(Fault("lidar_time_offset", {0, 1}), "'lidar_time_offset' takes 1 number (offset [s])");
  EXPECT_EQ(Fault("imu_gap", {1}), "'imu_gap' takes no value");
  EXPECT_EQ(Fault("imu_gap", {}), "");
  EXPECT_EQ(Fault("gnss_noise_scale", {0}), "ratio must be positive, is 0");
  EXPECT_EQ(Fault("gyro_bias_process", {1, -3}), "tau must be positive, is -3");
  EXPECT_EQ(Fault("gyro_bias_process", {-1, 3}), "sigma must not be negative, is -1");
  EXPECT_EQ(Fault("p2p_outliers", {1.2, 1}), "share must lie between 0 and 1, is 1.2");
  EXPECT_EQ(Fault("lidar_scan_cone", {-90}), "angle must lie between -45 and 45 deg, is -90");
  EXPECT_THAT(Fault("lidar_range_scale", {std::nan("")}), HasSubstr("must lie between"));
}

// --- The tests below compare the table with docs/reference/effects.md row by row.

std::vector<std::string> Cells(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream stream(row.substr(1));
  for (std::string cell; std::getline(stream, cell, '|');) {
    const auto begin = cell.find_first_not_of(' ');
    const auto end = cell.find_last_not_of(' ');
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
  }
  return cells;
}

/// Returns the rows of the first table below a heading, without the two head rows.
std::vector<std::vector<std::string>> TableBelow(const std::string& heading) {
  std::ifstream page(std::string(DN_REFERENCE_DIR) + "/effects.md");
  std::string line;
  while (std::getline(page, line) && line != heading) {
  }
  std::vector<std::vector<std::string>> rows;
  while (std::getline(page, line) && line.rfind("##", 0) != 0) {
    if (line.rfind('|', 0) == 0) rows.push_back(Cells(line));
  }
  if (rows.size() >= 2) rows.erase(rows.begin(), rows.begin() + 2);
  return rows;
}

std::string Short(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Formats the value cell: "x, y, z [m]" or "sigma [mg], tau [s]".
std::string ValueCell(const EffectSpec& effect) {
  std::string text;
  for (std::size_t i = 0; i < effect.components.size(); ++i) {
    const EffectComponent& part = effect.components[i];
    text += (i == 0 ? "" : ", ") + part.name;
    const bool last =
        i + 1 == effect.components.size() || effect.components[i + 1].unit != part.unit;
    if (last) text += " [" + part.unit + "]";
  }
  return text;
}

/// Formats the typical values: "0.03" or "0.02, 40". Equal neighbours with one unit appear once.
std::string TypicalCell(const EffectSpec& effect) {
  std::string text;
  for (std::size_t i = 0; i < effect.components.size(); ++i) {
    const EffectComponent& part = effect.components[i];
    const bool same = i > 0 && effect.components[i - 1].unit == part.unit &&
                      effect.components[i - 1].typical == part.typical;
    if (!same) text += (text.empty() ? "" : ", ") + Short(part.typical);
  }
  return text;
}

TEST(EffectTable, AgreesWithTheDocuments) {
  const std::map<EffectKind, std::string> kinds{{EffectKind::kFixed, "fixed"},
                                                {EffectKind::kProcess, "stochastic"},
                                                {EffectKind::kNoise, "stochastic"},
                                                {EffectKind::kOutliers, "stochastic"},
                                                {EffectKind::kFault, "fault"}};
  const auto rows = TableBelow("## The table");
  ASSERT_EQ(rows.size(), EffectTable().size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const EffectSpec& effect = EffectTable()[i];
    ASSERT_EQ(rows[i].size(), 6u) << effect.name;
    EXPECT_EQ(rows[i][0], "`" + effect.name + "`");
    EXPECT_EQ(rows[i][1], ValueCell(effect)) << effect.name;
    const std::string key = TimingKey(effect.timing);
    EXPECT_EQ(rows[i][2], key.empty() ? "" : "`" + key + "`") << effect.name;
    EXPECT_EQ(rows[i][3], kinds.at(effect.kind)) << effect.name;
    EXPECT_EQ(rows[i][4], TypicalCell(effect)) << effect.name;
    EXPECT_NE(rows[i][5], "") << effect.name;
  }
}

}  // namespace dn::effects_test
