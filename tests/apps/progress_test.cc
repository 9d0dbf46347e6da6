#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;

std::vector<Json> JsonLines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(Json::parse(line));
  return lines;
}

TEST(JsonProgress, HasALineForEachStageAndHowMuchOfItIsDone) {
  const TempFolder folder;
  const ProgramRun run =
      RunProgram({"monte-carlo", ShortScenario().string(), "--flights", "3", "--threads", "1",
                  "--json-progress", "--out", (folder.path() / "m").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  double elapsed_s = 0.0, done = 0.0;
  int times_left = 0;
  for (const Json& line : JsonLines(run.err)) {
    EXPECT_EQ(line["command"], "monte-carlo");
    EXPECT_GE(line["elapsed_s"].get<double>(), elapsed_s);
    elapsed_s = line["elapsed_s"].get<double>();
    if (!line.contains("done")) continue;
    EXPECT_EQ(line["of"], 3.0) << line;
    EXPECT_GT(line["done"].get<double>(), done);
    done = line["done"].get<double>();
    if (!line.contains("left_s")) continue;
    EXPECT_GE(line["left_s"].get<double>(), 0.0);
    EXPECT_EQ(line["left_s"] == 0.0, done == 3.0);
    ++times_left;
  }
  EXPECT_EQ(done, 3.0);
  EXPECT_EQ(times_left, 2);  // the first of three steps has no estimate yet
}

TEST(JsonProgress, EndsStageByStage) {
  const TempFolder folder;
  const ProgramRun run = RunProgram({"simulate", ShortScenario().string(), "--json-progress",
                                     "--out", (folder.path() / "f").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::vector<std::string> stages;
  for (const Json& line : JsonLines(run.err)) {
    const auto stage = line["stage"].get<std::string>();
    if (stages.empty() || stages.back() != stage) stages.push_back(stage);
  }
  EXPECT_GE(stages.size(), 3U);
  EXPECT_THAT(stages.back(), HasSubstr("writing"));
}

TEST(JsonProgress, AnErrorStaysALineToRead) {
  const ProgramRun run = RunProgram(
      {"calibrate", "nowhere", "--json-progress", "--out", (TempFolder().path() / "r").string()});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_THAT(run.err, HasSubstr("dn calibrate: error: "));
}

}  // namespace dn::testing::apps_test
