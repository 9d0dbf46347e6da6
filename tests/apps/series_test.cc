#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "page_numbers.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::series_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

ProgramRun Fly(const fs::path& out, const std::string& shard, const std::string& flights = "3") {
  return RunProgram({"monte-carlo", ShortScenario(), "--flights", flights, "--epoch-spacing", "20",
                     "--seed", "5", "--threads", "1", "--shard", shard, "--out", out});
}

ProgramRun Merge(const std::vector<fs::path>& folders, const fs::path& out) {
  std::vector<std::string> arguments{"merge"};
  for (const fs::path& folder : folders) arguments.push_back(folder);
  arguments.insert(arguments.end(), {"--out", out});
  return RunProgram(arguments);
}

/// Two shards of a series of three flights, simulated once.
class SeriesOfThree : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    one_ = Fly(One(), "1/2");
    two_ = Fly(Two(), "2/2");
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }
  static fs::path One() { return Path("one"); }
  static fs::path Two() { return Path("two"); }

  static TempFolder* folder_;
  static ProgramRun one_, two_;
};

TempFolder* SeriesOfThree::folder_ = nullptr;
ProgramRun SeriesOfThree::one_, SeriesOfThree::two_;

TEST_F(SeriesOfThree, AShardHasEveryNthFlight) {
  ASSERT_EQ(one_.exit_code, 0) << one_.err;
  ASSERT_EQ(two_.exit_code, 0) << two_.err;
  EXPECT_THAT(one_.out, HasSubstr("2 flights of short"));
  EXPECT_TRUE(fs::exists(One() / "flights" / "000005.json"));
  EXPECT_TRUE(fs::exists(One() / "flights" / "000007.json"));
  EXPECT_FALSE(fs::exists(One() / "flights" / "000006.json"));
  EXPECT_TRUE(fs::exists(Two() / "flights" / "000006.json"));
}

TEST_F(SeriesOfThree, MergedShardsAreTheBytesOfOneRun) {
  const fs::path merged = Path("merged"), whole = Path("whole");
  const ProgramRun merge = Merge({Two(), One()}, merged);
  ASSERT_EQ(merge.exit_code, 0) << merge.err;
  ExpectPageOfItsFiles(merged, 30);
  fs::create_directories(whole);
  fs::copy(merged / "flights", whole / "flights");
  const ProgramRun one_run = Fly(whole, "1/1");  // only evaluates: all flights are recorded
  ASSERT_EQ(one_run.exit_code, 0) << one_run.err;
  EXPECT_EQ(merge.out, one_run.out);
  std::vector<std::string> names = NamesIn(whole);
  EXPECT_EQ(NamesIn(merged), names);
  for (const std::string& name : names) {
    if (name == "flights" || name == "report.json") continue;
    EXPECT_EQ(ContentOf(merged / name), ContentOf(whole / name)) << name;
  }
  EXPECT_EQ(Json::parse(ContentOf(merged / "monte_carlo.json"))["flights"], 3);
}

TEST_F(SeriesOfThree, WhatDoesNotFitTogetherIsRefused) {
  const ProgramRun missing = Merge({One()}, Path("refused"));
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("1 of 3 flights are missing, such as 6"));
  const ProgramRun twice = Merge({One(), One()}, Path("refused"));
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_THAT(twice.err, HasSubstr("flight 5 is in two of the folders"));
  const ProgramRun nothing = Merge({One(), ShortFlight()}, Path("refused"));
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("no finished run"));
  const ProgramRun other = Fly(Path("other"), "2/2", "4");
  ASSERT_EQ(other.exit_code, 0) << other.err;
  const ProgramRun mixed = Merge({One(), Path("other")}, Path("refused"));
  EXPECT_EQ(mixed.exit_code, 2);
  EXPECT_THAT(mixed.err, HasSubstr("not a shard of the series"));
}

TEST_F(SeriesOfThree, AShardIsINotMoreThanN) {
  for (const char* shard : {"0/2", "3/2", "1", "a/b", "1/2x", "/2", "-1/2"}) {
    const ProgramRun run = Fly(Path("never"), shard);
    EXPECT_EQ(run.exit_code, 2) << shard;
    EXPECT_THAT(run.err, HasSubstr("is not a shard")) << shard;
  }
  const ProgramRun empty = Fly(Path("never"), "4/4");
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_THAT(empty.err, HasSubstr("has none"));
}

}  // namespace dn::testing::series_test
