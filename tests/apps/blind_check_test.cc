#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <system_error>
#include <thread>
#include <utility>

#include "changed_copy.h"
#include "page_numbers.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::vector<std::string> BlindCheckArguments(const fs::path& out, const std::string& shard) {
  return {"blind-check", "--flights",     "2",     "--scenarios", ShortScenario(), "--seed",
          "8",           "--threads",     "1",     "--shard",     shard,           "--out",
          out,           "--gap-options", "screen"};
}

bool HoldsAnywhere(const fs::path& folder, const std::string& name) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().filename() == name) return true;
  }
  return false;
}

/// Two flights in two shards, simulated once.
class BlindCheck : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    one_ = RunProgram(BlindCheckArguments(Path("one"), "1/2"));
    two_ = RunProgram(BlindCheckArguments(Path("two"), "2/2"));
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }

  static TempFolder* folder_;
  static ProgramRun one_, two_;
};

TempFolder* BlindCheck::folder_ = nullptr;
ProgramRun BlindCheck::one_, BlindCheck::two_;

TEST_F(BlindCheck, TheTruthLiesApartFromTheFlight) {
  ASSERT_EQ(one_.exit_code, 0) << one_.err;
  const fs::path out = Path("one");
  EXPECT_TRUE(fs::exists(out / "flights" / "001" / "IMU.txt"));
  EXPECT_FALSE(HoldsAnywhere(out / "flights", "truth.yaml"));
  EXPECT_FALSE(HoldsAnywhere(out / "flights", "reference.out"));
  EXPECT_FALSE(HoldsAnywhere(out / "runs", "truth.yaml"));
  EXPECT_THAT(FileContent(out / "truth" / "001.yaml"), HasSubstr("boresight_deg"));
  EXPECT_FALSE(fs::exists(out / "flights" / "002")) << "of the other shard";
}

TEST_F(BlindCheck, EveryFlightIsDiagnosedAndCalibrated) {
  ASSERT_EQ(one_.exit_code, 0) << one_.err;
  const Json record = Json::parse(FileContent(Path("one") / "records" / "000001.json"));
  EXPECT_FALSE(record.at("diagnosis").at("result").is_null()) << record.at("diagnosis");
  EXPECT_FALSE(record.at("calibrated").at("result").is_null()) << record.at("calibrated");
  EXPECT_FALSE(record.at("adapted").at("result").is_null()) << record.at("adapted");
  EXPECT_GT(record.at("diagnosis").at("time_s").get<double>(), 0.0);
  EXPECT_EQ(FileContent(Path("one") / "table.txt"), one_.out);
  EXPECT_THAT(FileContent(Path("one") / "flights.csv"), HasSubstr("\n1,"));
}

TEST_F(BlindCheck, MergedShardsAreTheBytesOfOneRun) {
  ASSERT_EQ(two_.exit_code, 0) << two_.err;
  const fs::path merged = Path("merged"), whole = Path("whole");
  const ProgramRun merge = RunProgram({"merge", Path("one"), Path("two"), "--out", merged});
  ASSERT_EQ(merge.exit_code, 0) << merge.err;
  ExpectPageMatchesFiles(merged, 30);
  fs::create_directories(whole);
  fs::copy(merged / "records", whole / "records");
  const ProgramRun one_run =
      RunProgram(BlindCheckArguments(whole, "1/1"));  // only evaluates records
  ASSERT_EQ(one_run.exit_code, 0) << one_run.err;
  EXPECT_FALSE(fs::exists(whole / "flights")) << "flown again";
  for (const char* name :
       {"blind_check.json", "table.txt", "flights.csv", "config.resolved.yaml"}) {
    EXPECT_EQ(FileContent(merged / name), FileContent(whole / name)) << name;
  }
  EXPECT_EQ(Json::parse(FileContent(merged / "blind_check.json")).at("flights"), 2);
}

TEST_F(BlindCheck, ARecordIsTheOneThatItsNameSays) {
  const std::pair<const char*, Json> changes[] = {
      {"number", 2},        {"number", 1e12},
      {"seed", 5},          {"base", "another"},
      {"content", "three"}, {"effects", {{{"effect", "x"}, {"value", {1}}}}},
      {"strips", -1},       {"boresight_deg", {1, 2, nullptr}},
      {"made_from", "0123"}};
  for (const auto& [key, value] : changes) {
    const fs::path changed = ChangedCopy(Path("one"), Path("changed"), "records/000001.json",
                                         [&, k = key, v = value](Json* json) { (*json)[k] = v; });
    const std::string message = "not the record of this flight: /" + std::string(key);
    const ProgramRun merge = RunProgram({"merge", changed, Path("two"), "--out", Path("refused")});
    EXPECT_EQ(merge.exit_code, 1) << key;
    EXPECT_THAT(merge.err, HasSubstr(message));
    const ProgramRun resumed = RunProgram(BlindCheckArguments(changed, "1/2"));
    EXPECT_EQ(resumed.exit_code, 1) << key;
    EXPECT_THAT(resumed.err, HasSubstr(message));
  }
}

TEST_F(BlindCheck, AFolderOfItsResultsThatIsALinkIsRefused) {
  for (const char* name : {"flights", "truth", "runs", "records", "flights/001"}) {
    const fs::path out = Path("linked"), elsewhere = Path("elsewhere");
    fs::remove_all(out);
    fs::create_directories((out / name).parent_path());
    fs::create_directories(elsewhere / "001");
    std::ofstream(elsewhere / "001/notes.txt") << "of the user";
    fs::create_directory_symlink(elsewhere, out / name);
    const ProgramRun run = RunProgram(BlindCheckArguments(out, "1/2"));
    EXPECT_EQ(run.exit_code, 1) << name;
    EXPECT_THAT(run.err, HasSubstr("is a file or link, but the results need a folder"));
    EXPECT_EQ(NamesIn(elsewhere), std::vector<std::string>{"001"});
    EXPECT_EQ(NamesIn(elsewhere / "001"), std::vector<std::string>{"notes.txt"});
  }
}

TEST_F(BlindCheck, RecordsOfAnotherSeriesAreNotMixed) {
  std::vector<std::string> other = BlindCheckArguments(Path("one"), "1/2");
  other[6] = "9";
  const ProgramRun run = RunProgram(other);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("another scenario, version or option"));
}

TEST(BlindCheckUsage, AScenarioThatIsNoneIsNamed) {
  const TempFolder folder;
  const ProgramRun run = RunProgram(
      {"blind-check", "--scenarios", "lar2_rest,nowhere", "--out", folder.path() / "out"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("'nowhere' is neither a scenario file nor a shipped scenario"));
}

std::vector<std::string> PhysicsArguments(const fs::path& folder, const std::string& text) {
  std::ofstream(folder / "physics.yaml") << text;
  std::vector<std::string> arguments = BlindCheckArguments(folder / "out", "1/1");
  arguments[2] = "1";
  for (const std::string more : {"--only", "outsider", "--physics"}) arguments.push_back(more);
  arguments.push_back(folder / "physics.yaml");
  return arguments;
}

TEST(BlindCheckUsage, PhysicsOfAFileAreFlown) {
  const TempFolder folder;
  const std::string entry = "{name: mine, adds_to: lidar_range_m, size: 0.1, shape: per_strip}";
  const ProgramRun run = RunProgram(PhysicsArguments(folder.path(), "physics: [" + entry + "]\n"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(FileContent(folder.path() / "out" / "truth" / "001.yaml"),
              HasSubstr("outsider: {name: mine, parameters: {"));
  const Json record = Json::parse(FileContent(folder.path() / "out" / "records" / "000001.json"));
  EXPECT_EQ(record.at("outsider").at("name"), "mine");
  EXPECT_FALSE(record.at("signature").is_null());
  const ProgramRun other = RunProgram(PhysicsArguments(
      folder.path(), "physics: [{name: mine, adds_to: gnss_m, size: 0.1, shape: walk}]\n"));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("another scenario, version or option"));
}

TEST(BlindCheckUsage, APhysicsFileThatIsWrongIsRefusedWithItsPlace) {
  const TempFolder folder;
  const ProgramRun run = RunProgram(PhysicsArguments(
      folder.path(), "physics:\n  - {name: a, adds_to: gnss_m, size: 1, shape: wave}\n"));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("physics.yaml:2"));
  EXPECT_THAT(run.err, HasSubstr("per_strip"));
  EXPECT_FALSE(fs::exists(folder.path() / "out" / "records"));
}

/// Returns whether a staging folder lies anywhere below `folder`, or a folder vanishes during the
/// search.
bool HoldsStaging(const fs::path& folder) {
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; at != end; at.increment(error)) {
    if (at->path().filename().string().starts_with(".dn-staging")) return true;
  }
  return static_cast<bool>(error);
}

/// Waits until a program that was asked to end has removed what it staged.
bool NothingStaysStaged(const fs::path& folder) {
  for (int i = 0; i < 50; ++i) {
    if (!HoldsStaging(folder)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}

/// Runs two flights at a time, so that one is still processed by its program when the other one is
/// finished.
ProgramOptions TwoAtATime(const fs::path& out) {
  ProgramOptions options;
  options.arguments = BlindCheckArguments(out, "1/1");
  options.arguments[2] = "50";
  options.arguments[8] = "2";
  options.signal_after = "flights (";
  return options;
}

TEST(BlindCheckUsageManyRuns, AKilledCheckLeavesNothingStaged) {
  const TempFolder folder;
  ProgramOptions options = TwoAtATime(folder.path() / "out");
  options.signal = SIGKILL;
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.signal, SIGKILL);
  EXPECT_TRUE(NothingStaysStaged(folder.path() / "out" / "runs"));
}

TEST(BlindCheckUsage, AnInterruptedCheckEndsItsPrograms) {
  const TempFolder folder;
  ProgramOptions options = TwoAtATime(folder.path() / "out");
  options.signal = SIGINT;
  const ProgramRun run = RunProgram(options);
  EXPECT_TRUE(NothingStaysStaged(folder.path() / "out" / "runs"));
  EXPECT_EQ(run.exit_code, 130) << run.err;
  EXPECT_FALSE(NamesIn(folder.path() / "out" / "records").empty());
  EXPECT_FALSE(fs::exists(folder.path() / "out" / "blind_check.json"));
}

}  // namespace dn::testing::apps_test
