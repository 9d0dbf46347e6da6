#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::vector<std::string> MonteCarloArguments(const fs::path& out, const std::string& flights) {
  return {"monte-carlo", ShortScenario(), "--flights", flights, "--epoch-spacing",
          "20",          "--threads",     "2",         "--out", out};
}

TEST(MonteCarloManyRuns, JudgesFliesOnAndRefusesToMix) {
  const TempFolder folder;
  const fs::path out = folder.path() / "mc";
  const ProgramRun first = RunProgram(MonteCarloArguments(out, "2"));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("2 flights of short"));
  EXPECT_THAT(first.out, HasSubstr("boresight NEES / 3"));
  const Json two = Json::parse(FileContent(out / "monte_carlo.json"));
  EXPECT_EQ(two["schema"], "dn.monte_carlo/1");
  EXPECT_EQ(two["flights"], 2);
  EXPECT_EQ(two["trajectory"].size(), 5U);
  EXPECT_EQ(FileContent(out / "table.txt"), first.out);
  const auto made = fs::last_write_time(out / "flights" / "000001.json");

  const ProgramRun more = RunProgram(MonteCarloArguments(out, "3"));
  ASSERT_EQ(more.exit_code, 0) << more.err;
  EXPECT_EQ(Json::parse(FileContent(out / "monte_carlo.json"))["flights"], 3);
  EXPECT_EQ(fs::last_write_time(out / "flights" / "000001.json"), made) << "flown again";

  std::vector<std::string> other = MonteCarloArguments(out, "3");
  other.emplace_back("--without-pairs");
  const ProgramRun mixed = RunProgram(other);
  EXPECT_EQ(mixed.exit_code, 2);
  EXPECT_THAT(mixed.err, HasSubstr("another scenario, version or option"));

  std::ofstream(out / "flights" / "000002.json") << "{\"seed\": 2";
  const ProgramRun damaged = RunProgram(MonteCarloArguments(out, "3"));
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_THAT(damaged.err, HasSubstr("000002.json"));
  EXPECT_THAT(damaged.err, HasSubstr("delete the file"));
}

TEST(MonteCarloManyRuns, AnInterruptedRunKeepsItsFlights) {
  const TempFolder folder;
  const fs::path out = folder.path() / "mc";
  ProgramOptions options;
  options.arguments = MonteCarloArguments(out, "1000");
  options.signal = SIGINT;
  options.signal_after = "flights (";
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 130) << run.err;
  EXPECT_THAT(run.err, ::testing::HasSubstr("run the same command again to continue"));
  EXPECT_FALSE(NamesIn(out / "flights").empty());
  EXPECT_FALSE(fs::exists(out / "monte_carlo.json"));
}

}  // namespace dn::testing::apps_test
