#include <dn/error.h>
#include <dn/geo/read_file.h>
#include <dn/study/sweep.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "study/small_designs.h"
#include "testing/temp_folder.h"

namespace dn::testing::study_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A sweep over the two strips; its base is in the same folder.
struct SmallSweep {
  TempFolder folder;
  std::string where = (folder.path() / "sweep.yaml").string();

  SmallSweep() { std::ofstream(folder.path() / "two.yaml") << kTwoStrips; }
  Sweep Parse(const std::string& keys) const {
    return Sweep::Parse("base: two.yaml\nsweep:\n" + keys, where);
  }
};

std::string ParseErrorText(const std::string& keys) {
  try {
    SmallSweep().Parse(keys);
  } catch (const InvalidConfig& error) {
    return error.what();
  }
  return "no error";
}

TEST(Sweep, IsEveryCombination) {
  const SmallSweep small;
  const Sweep sweep = small.Parse(
      "  gnss.sigma_enu_m: {good: [0.01, 0.01, 0.02], poor: [0.1, 0.1, 0.2]}\n"
      "  pairs.count: [100, 200, 300]\n");
  ASSERT_EQ(sweep.size(), 6u);
  EXPECT_THAT(sweep.Labels(1), ElementsAre("good", "100"));
  EXPECT_THAT(sweep.Labels(3), ElementsAre("good", "300"));
  EXPECT_THAT(sweep.Labels(4), ElementsAre("poor", "100"));
  const Scenario scenario = sweep.DesignScenario(5);
  EXPECT_EQ(scenario.pairs.count, 200);
  EXPECT_DOUBLE_EQ(scenario.gnss.sigma_enu_m.z(), 0.2);
  EXPECT_DOUBLE_EQ(scenario.lidar.fov_rad, TwoStrips().lidar.fov_rad);
  EXPECT_THROW(sweep.Labels(7), InvalidInput);
  EXPECT_THROW(sweep.Labels(0), InvalidInput);
}

TEST(Sweep, WhatIsFreeMayBeSwept) {
  const SmallSweep small;
  const Sweep sweep = small.Parse("  estimate: [[], [gnss_lever_arm, lidar_time_offset]]\n");
  EXPECT_EQ(sweep.DesignEstimate(1), "");
  EXPECT_EQ(sweep.DesignEstimate(2), "gnss_lever_arm, lidar_time_offset");
}

TEST(Sweep, RefusesWhatIsNone) {
  EXPECT_THAT(ParseErrorText("  pairs.cuont: [1]\n"), HasSubstr("cuont"));
  EXPECT_THAT(ParseErrorText("  pairs.count: []\n"), HasSubstr("no values"));
  EXPECT_THAT(ParseErrorText("  pairs.count: [5, 5]\n"), HasSubstr("twice"));
  EXPECT_THAT(ParseErrorText("  pairs.count.more: [5]\n"), HasSubstr("pairs.count"));
  EXPECT_THAT(ParseErrorText("  []\n"), HasSubstr("map"));
  EXPECT_THROW(Sweep::Parse("base: no_such\nsweep: {pairs.count: [1]}", "x.yaml"), InvalidConfig);
  EXPECT_THROW(Sweep::Parse("bas: lar3\nsweep: {pairs.count: [1]}", "x.yaml"), InvalidConfig);
  EXPECT_THROW(Sweep::Parse("base: lar3\nsweep: {imu.preset: [airins]}", "x.yaml"), InvalidConfig);
}

TEST(Sweep, IsCountedBeforeItsValuesAreRead) {
  std::string values = "0";
  for (int i = 1; i < 150000; ++i) values += "," + std::to_string(i);
  EXPECT_THAT(ParseErrorText("  pairs.count: [" + values + "]\n"),
              HasSubstr("makes more than 10000 designs"));
  std::string named = "v0: 1";
  for (int i = 1; i < 60000; ++i) named += ", v" + std::to_string(i) + ": 1";
  EXPECT_THAT(ParseErrorText("  pairs.count: {" + named + "}\n"),
              HasSubstr("makes more than 10000 designs"));
}

TEST(Sweep, NamesAreFitForATerminal) {
  EXPECT_THAT(ParseErrorText("  pairs.count: {\"\\e[31mred\": 1, b: 2}\n"),
              HasSubstr("the name ' [31mred' contains a line break"));
}

TEST(Sweep, WhatIsFreeMustBeAnUnknown) {
  EXPECT_THAT(ParseErrorText("  pairs.count: [5]\nestimate: [gnss_lever_arn]\n"),
              HasSubstr("unknown name 'gnss_lever_arn'; did you mean 'gnss_lever_arm'?"));
  EXPECT_THAT(ParseErrorText("  estimate: [[], [gnss_lever_arn]]\n"),
              HasSubstr("did you mean 'gnss_lever_arm'?"));
}

TEST(Sweep, ARowHasTheStudyOfItsDesign) {
  const SmallSweep small;
  const Sweep sweep = small.Parse("  pairs.count: [200, 400]\n");
  const SweepRecord few = StudySweepDesign(sweep, 1, {});
  const SweepRecord many = StudySweepDesign(sweep, 2, {});
  ASSERT_EQ(few.failure, "");
  ASSERT_EQ(many.failure, "");
  for (int i = 0; i < 3; ++i) EXPECT_LT(many.sigma_rad[i], few.sigma_rad[i]) << i;
  StudyOptions options;
  options.remedies = false;
  const StudyResult study = Study(TwoStripsWith("pairs.count", "400"), options);
  EXPECT_TRUE(many.sigma_rad.isApprox(study.boresight.sigma_rad(), 1e-9));
  EXPECT_NEAR(many.condition_number, study.boresight.condition_number,
              1e-9 * many.condition_number);
}

TEST(Sweep, ASingularDesignHasAReasonAndNoNumbers) {
  const SmallSweep small;
  const Sweep sweep = small.Parse("  plan.lines: {one: [[-600, 0, 600, 0, 200, 45]]}\n");
  const SweepRecord record = StudySweepDesign(sweep, 1, {});
  EXPECT_THAT(record.failure, HasSubstr("not observable"));
  const std::string csv = SweepCsv({"plan.lines"}, {record});
  EXPECT_THAT(csv, HasSubstr("\n1,one,,,,,,,,,,,\"the boresight is not observable"));
  EXPECT_THAT(SweepTable({"plan.lines"}, {record}), HasSubstr("singular"));
}

TEST(Sweep, RecordsSurviveAsJson) {
  SweepRecord record;
  record.number = 7;
  record.labels = {"a, b", "c"};
  record.sigma_rad = {0.1, 1.0 / 3.0, 3e-7};
  record.condition_number = 12.5;
  record.correlation_biases = 0.25;
  record.strips = {1e-3, 2e-3, 0.01};
  const SweepRecord read = SweepRecordFromJson(Json::parse(ToJson(record).dump()));
  EXPECT_EQ(SweepCsv({"x", "y"}, {read}), SweepCsv({"x", "y"}, {record}));
  EXPECT_THAT(SweepCsv({"x", "y"}, {read}), HasSubstr("7,\"a, b\",c,"));
}

TEST(Sweep, HasAPlotForEveryKeyThatVaries) {
  SweepRecord one, two;
  one.labels = {"a", "c"};
  two.labels = {"b", "c"};
  one.sigma_rad = two.sigma_rad = Eigen::Vector3d::Ones();
  const std::vector<StudyPlot> plots = SweepPlots({"plan.lines", "imu"}, {one, two});
  ASSERT_EQ(plots.size(), 1u);
  EXPECT_EQ(plots[0].file, "sweep_plan_lines.svg");
  EXPECT_THAT(plots[0].panels[0].rows, ElementsAre("a", "b"));
}

TEST(Sweep, TheShippedOneIsOne) {
  const std::string file = std::string(DN_SWEEPS) + "/lines_and_grades.yaml";
  const Sweep sweep = Sweep::Parse(ReadWholeFile(file, 1 << 20), file);
  EXPECT_EQ(sweep.size(), 15u);
  EXPECT_THAT(sweep.Labels(15), ElementsAre("two_by_two", "mems"));
}

}  // namespace dn::testing::study_test
