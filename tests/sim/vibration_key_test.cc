#include <dn/error.h>
#include <dn/sim/scenario.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dn::sim_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

VibrationScenario Parse(const std::string& vibration) {
  return ParseScenario(
             "{name: x, origin_deg_m: [46, 7, 0], imu: {preset: airins}, lidar: {gsd_m: 1},\n"
             "plan: {lines: [[0, 0, 1000, 0, 200, 40]], vibration: " +
                 vibration + "}}",
             "file.yaml")
      .plan.vibration;
}

std::string VibrationFault(const std::string& vibration) {
  try {
    Parse(vibration);
  } catch (const InvalidConfig& error) {
    EXPECT_EQ(error.where().line, 2);
    return error.what();
  }
  return "";
}

TEST(VibrationKey, ConvertsToSiAndFillsDefaults) {
  const VibrationScenario v = Parse(
      "{lines: [{frequency_hz: 21, accel_m_s2: 0.5, angle_urad: [1, 2, 4], wander_percent: 2}], "
      "resonances: [{frequency_hz: 30}], broadband: [{low_hz: 5, high_hz: 90, accel_m_s2: 0.1}]}");
  ASSERT_EQ(v.lines.size(), 1u);
  EXPECT_EQ(v.lines[0].level.accel_mps2, Eigen::Vector3d::Constant(0.5));
  EXPECT_DOUBLE_EQ(v.lines[0].level.angle_rad.z(), 4e-6);
  EXPECT_DOUBLE_EQ(v.lines[0].wander, 0.02);
  EXPECT_EQ(v.lines[0].harmonics, 1);
  EXPECT_EQ(v.resonances.at(0).damping, 0.05);
  EXPECT_EQ(v.broadband.at(0).high_hz, 90.0);
  EXPECT_FALSE(v.preset.has_value());
}

TEST(VibrationKey, NamesPresets) {
  EXPECT_TRUE(Parse("none").empty());
  EXPECT_TRUE(Parse("~").empty());
  for (const std::string& name : VibrationPresetNames()) {
    EXPECT_EQ(Parse(name).preset, name);
    EXPECT_FALSE(Parse(name).empty()) << name;
  }
}

TEST(VibrationKey, ReportsWhatIsWrong) {
  EXPECT_THAT(VibrationFault("helicoptr"),
              AllOf(HasSubstr("plan.vibration"), HasSubstr("'helicopter'"), HasSubstr("none")));
  EXPECT_THAT(VibrationFault("{line: []}"), AllOf(HasSubstr("'line'"), HasSubstr("'lines'")));
  EXPECT_THAT(VibrationFault("[helicopter]"), HasSubstr("plan.vibration"));
  EXPECT_THAT(VibrationFault("{lines: [{accel_m_s2: 1}]}"), HasSubstr("frequency_hz"));
  EXPECT_THAT(VibrationFault("{lines: [{frequency_hz: 0.1}]}"), HasSubstr("between 0.5 and 2000"));
  EXPECT_THAT(VibrationFault("{lines: [{frequency_hz: 21, accel_m_s2: -1}]}"),
              AllOf(HasSubstr("accel_m_s2"), HasSubstr("between 0 and 100")));
  EXPECT_THAT(VibrationFault("{lines: [{frequency_hz: 21, accel_m_s2: [1, 2]}]}"),
              HasSubstr("3 numbers"));
  EXPECT_THAT(VibrationFault("{lines: [{frequency_hz: 500, harmonics: 5}]}"),
              AllOf(HasSubstr("harmonics"), HasSubstr("2000 Hz")));
  EXPECT_THAT(VibrationFault("{lines: [{frequency_hz: 21, wander_percent: 30}]}"),
              HasSubstr("wander_percent"));
  EXPECT_THAT(VibrationFault("{resonances: [{frequency_hz: 21, damping: 0}]}"),
              HasSubstr("damping"));
  EXPECT_THAT(VibrationFault("{broadband: [{low_hz: 21, high_hz: 20}]}"),
              HasSubstr("higher than low_hz"));
}

}  // namespace dn::sim_test
