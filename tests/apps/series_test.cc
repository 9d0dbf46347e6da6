#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <functional>
#include <tuple>
#include <utility>

#include "changed_copy.h"
#include "page_numbers.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

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
  ExpectPageMatchesFiles(merged, 30);
  fs::create_directories(whole);
  fs::copy(merged / "flights", whole / "flights");
  const ProgramRun one_run = Fly(whole, "1/1");  // only evaluates: all flights are recorded
  ASSERT_EQ(one_run.exit_code, 0) << one_run.err;
  EXPECT_EQ(merge.out, one_run.out);
  std::vector<std::string> names = NamesIn(whole);
  EXPECT_EQ(NamesIn(merged), names);
  for (const std::string& name : names) {
    if (name == "flights" || name == "report.json") continue;
    EXPECT_EQ(FileContent(merged / name), FileContent(whole / name)) << name;
  }
  EXPECT_EQ(Json::parse(FileContent(merged / "monte_carlo.json"))["flights"], 3);
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
  EXPECT_THAT(nothing.err, HasSubstr("not the report of a finished run"));
  const ProgramRun other = Fly(Path("other"), "2/2", "4");
  ASSERT_EQ(other.exit_code, 0) << other.err;
  const ProgramRun mixed = Merge({One(), Path("other")}, Path("refused"));
  EXPECT_EQ(mixed.exit_code, 2);
  EXPECT_THAT(mixed.err, HasSubstr("not a shard of the series"));
}

TEST_F(SeriesOfThree, ARecordIsTheOneThatItsNameSays) {
  const std::string record = "flights/000005.json";
  const std::pair<const char*, Json> changes[] = {{"seed", 7},
                                                  {"seed", "5"},
                                                  {"redundancy", 1e308},
                                                  {"redundancy", 1e30},
                                                  {"redundancy", 0},
                                                  {"redundancy", -5},
                                                  {"chi2", -1.0},
                                                  {"check_p_value", 2.0},
                                                  {"with_pairs", false},
                                                  {"boresight_covariance_rad2", {{1, 0}, {0, 1}}},
                                                  {"epochs", {{1.0, 2.0}}},
                                                  {"made_from", "0123"}};
  for (const auto& [key, value] : changes) {
    const fs::path changed = ChangedCopy(One(), Path("changed"), record,
                                         [&, k = key, v = value](Json* json) { (*json)[k] = v; });
    const ProgramRun merge = Merge({changed, Two()}, Path("refused"));
    EXPECT_EQ(merge.exit_code, 1) << key;
    EXPECT_THAT(merge.err, HasSubstr("not the record of this flight: /" + std::string(key)));
    EXPECT_THAT(merge.err, HasSubstr(record));
    EXPECT_FALSE(fs::exists(Path("refused") / "flights")) << key;
    const ProgramRun resumed = Fly(changed, "1/2");
    EXPECT_EQ(resumed.exit_code, 1) << key;
    EXPECT_THAT(resumed.err, HasSubstr("not the record of this flight: /" + std::string(key)));
  }
}

TEST_F(SeriesOfThree, ARecordOfAnotherNumberIsRefused) {
  const fs::path changed = Path("renumbered");
  fs::copy(One(), changed, fs::copy_options::recursive);
  fs::copy(One() / "flights/000005.json", changed / "flights/000007.json",
           fs::copy_options::overwrite_existing);
  for (const ProgramRun& run : {Merge({changed, Two()}, Path("refused")), Fly(changed, "1/2")}) {
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, HasSubstr("/seed is 5, not 7 as the name of the file says"));
  }
}

TEST_F(SeriesOfThree, TheReportOfAShardIsThatOfItsRecords) {
  const std::tuple<const char*, Json, const char*> changes[] = {
      {"flights", 1'000'000'000'000, "/series/flights is not an integer within 1 and 1000000"},
      {"flights", 1e18, "/series/flights is not an integer within 1 and 1000000"},
      {"first", -1, "/series/first is not an integer"},
      {"shard", "3/2", "/series/shard is not a shard i/N"},
      {"command", "match", "/series/command is not a command"},
      {"made_from", "0123", "not of one run"}};
  for (const auto& [key, value, message] : changes) {
    const fs::path changed =
        ChangedCopy(One(), Path("changed"), "report.json",
                    [&, k = key, v = value](Json* json) { (*json)["series"][k] = v; });
    const ProgramRun merge = Merge({changed, Two()}, Path("refused"));
    EXPECT_EQ(merge.exit_code, 1) << key;
    EXPECT_THAT(merge.err, HasSubstr(message));
  }
  const fs::path other_build =
      ChangedCopy(One(), Path("changed"), "flights/made_from.json",
                  [](Json* json) { (*json)["program"] = std::string(64, '0'); });
  EXPECT_THAT(Merge({other_build, Two()}, Path("refused")).err, HasSubstr("not of one run"));
  EXPECT_THAT(Fly(other_build, "1/2").err, HasSubstr("another build of this version"));
}

TEST_F(SeriesOfThree, WhatIsNoRegularFileIsRefusedAtOnce) {
  for (const char* name : {"report.json", "flights/made_from.json", "flights/000005.json"}) {
    const fs::path changed = Path("special");
    const auto renew = [&] {
      fs::remove_all(changed);
      fs::copy(One(), changed, fs::copy_options::recursive);
      fs::remove(changed / name);
    };
    renew();
    ASSERT_EQ(::mkfifo((changed / name).c_str(), 0600), 0);
    EXPECT_THAT(Merge({changed, Two()}, Path("refused")).err, HasSubstr("a named pipe")) << name;
    renew();
    fs::create_directory(changed / name);
    EXPECT_THAT(Merge({changed, Two()}, Path("refused")).err, HasSubstr("a folder")) << name;
    renew();
    fs::create_symlink("/dev/zero", changed / name);
    EXPECT_THAT(Merge({changed, Two()}, Path("refused")).err, HasSubstr("a device")) << name;
    if (std::string(name) == "report.json") continue;
    EXPECT_THAT(Fly(changed, "1/2").err, HasSubstr("a device")) << name;
  }
}

TEST_F(SeriesOfThree, AFolderOfRecordsThatIsALinkIsRefused) {
  const fs::path out = Path("linked");
  fs::create_directories(out);
  fs::create_directories(Path("elsewhere"));
  fs::create_directory_symlink(Path("elsewhere"), out / "flights");
  std::ofstream(Path("elsewhere") / ".mine.part") << "of the user";
  const ProgramRun run = Fly(out, "1/2");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("is a file or link, but the results need a folder"));
  EXPECT_EQ(NamesIn(Path("elsewhere")), std::vector<std::string>{".mine.part"});
}

/// The two designs of a sweep, a shard each.
class SweepOfTwo : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    folder_->Write("short.yaml", FileContent(ShortScenario()));
    folder_->Write("sweep.yaml",
                   "base: short.yaml\nsweep:\n  pairs.count: {few: 200, many: 400}\n");
    for (const char* shard : {"1", "2"}) {
      const ProgramRun run = RunProgram({"study", "--sweep", folder_->path() / "sweep.yaml",
                                         "--shard", std::string(shard) + "/2", "--threads", "1",
                                         "--out", folder_->path() / shard});
      ASSERT_EQ(run.exit_code, 0) << run.err;
    }
  }
  static void TearDownTestSuite() { delete folder_; }

  static ProgramRun MergeChanged(const std::function<void(Json*)>& change) {
    const fs::path& work = folder_->path();
    const fs::path changed =
        ChangedCopy(work / "1", work / "changed", "designs/000001.json", change);
    return Merge({changed, work / "2"}, work / "merged");
  }

  static TempFolder* folder_;
};

TempFolder* SweepOfTwo::folder_ = nullptr;

TEST_F(SweepOfTwo, AreMerged) {
  const ProgramRun run = MergeChanged([](Json*) {});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(SweepOfTwo, ADesignIsTheOneThatItsNameSays) {
  const std::pair<const char*, Json> changes[] = {{"labels", Json::array()},
                                                  {"labels", {"many"}},
                                                  {"labels", {"few", "few"}},
                                                  {"labels", 3},
                                                  {"number", 2},
                                                  {"sigma_rad", {0.0, 1.0, 1.0}},
                                                  {"correlation_angles", 2.0},
                                                  {"condition_number", nullptr}};
  for (const auto& [key, value] : changes) {
    const ProgramRun run = MergeChanged([&, k = key, v = value](Json* json) { (*json)[k] = v; });
    EXPECT_EQ(run.exit_code, 1) << key;
    EXPECT_THAT(run.err, HasSubstr("not the record of this flight: /" + std::string(key)));
  }
}

TEST_F(SeriesOfThree, AShardIsINotMoreThanN) {
  for (const char* shard : {"0/2", "3/2", "1", "a/b", "1/2x", "/2", "-1/2"}) {
    const ProgramRun run = Fly(Path("never"), shard);
    EXPECT_EQ(run.exit_code, 2) << shard;
    EXPECT_THAT(run.err, HasSubstr("is not a shard")) << shard;
  }
  const ProgramRun empty = Fly(Path("never"), "4/4");
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_THAT(empty.err, HasSubstr("is empty"));
}

}  // namespace dn::testing::apps_test
