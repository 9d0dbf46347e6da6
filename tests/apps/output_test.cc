#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "damaged_flight.h"

namespace dn::testing::apps_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

std::vector<std::string> CalibrateInto(const fs::path& out) {
  return {"calibrate", ShortFlight().string(), "--out", out.string()};
}

/// Returns the names of staged or temporary files in the folder and its subfolders.
std::vector<std::string> HiddenNamesBelow(const fs::path& folder) {
  std::vector<std::string> hidden;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.')) hidden.push_back(name);
  }
  return hidden;
}

/// Simulates and calibrates with this number of threads. Returns the texts of the results without
/// the timings.
std::vector<std::string> FlyAndCalibrate(const fs::path& folder, const std::string& threads) {
  const std::string flight = (folder / "flight").string(), result = (folder / "result").string();
  EXPECT_EQ(RunProgram({"simulate", ShortScenario().string(), "--seed", "5", "--out", flight,
                        "--threads", threads})
                .exit_code,
            0);
  EXPECT_EQ(RunProgram({"calibrate", flight, "--out", result, "--threads", threads}).exit_code, 0);
  Json json = Json::parse(FileContent(folder / "result/result.json"));
  json.erase("timing_s");
  std::vector<std::string> texts{FormatJson(json)};
  for (const char* name :
       {"flight/IMU.txt", "flight/GPS.txt", "flight/reference.out", "result/trajectory.out",
        "result/trajectory_sigma.txt", "result/biases.txt"}) {
    texts.push_back(FileContent(folder / name));
  }
  return texts;
}

TEST(CliOutputManyRuns, TheSameSeedAndThreadsGiveTheSameBytes) {
  const TempFolder folder;
  for (const char* threads : {"1", "2"}) {
    const std::string name = threads;
    EXPECT_EQ(FlyAndCalibrate(folder.path() / (name + "a"), threads),
              FlyAndCalibrate(folder.path() / (name + "b"), threads))
        << threads << " threads";
  }
}

TEST(CliOutput, ReplacesTheFilesOfAnEarlierRun) {
  const TempFolder folder;
  folder.Write("r/result.json", "an earlier result");
  folder.Write("r/notes.txt", "of the user");
  ASSERT_EQ(RunProgram(CalibrateInto(folder.path() / "r")).exit_code, 0);
  EXPECT_EQ(Json::parse(FileContent(folder.path() / "r/result.json"))["schema"], "dn.result/1");
  EXPECT_EQ(FileContent(folder.path() / "r/notes.txt"), "of the user");
  EXPECT_THAT(HiddenNamesBelow(folder.path()), IsEmpty());
}

TEST(CliOutput, AFileWhereTheFolderShouldBe) {
  const TempFolder folder;
  folder.Write("taken", "x");
  for (const fs::path& out : {folder.path() / "taken", folder.path() / "taken/below"}) {
    const ProgramRun run = RunProgram(CalibrateInto(out));
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, HasSubstr(out.string()));
  }
  EXPECT_EQ(FileContent(folder.path() / "taken"), "x");
  EXPECT_THAT(NamesIn(folder.path()), ElementsAre("taken"));
}

TEST(CliOutput, AnUnusableFolderIsNoticedBeforeTheWork) {
  const TempFolder folder;
  folder.Write("taken", "x");
  const ProgramRun run = RunProgram(CalibrateInto(folder.path() / "taken"));
  EXPECT_THAT(run.err, StartsWith("dn calibrate: error: "));
}

TEST(CliOutput, AFullDiskLeavesTheEarlierResult) {
  const TempFolder folder;
  folder.Write("r/result.json", "an earlier result");
  ProgramOptions options;
  options.arguments = CalibrateInto(folder.path() / "r");
  options.max_file_bytes = 50000;  // enough for report.json, but not for trajectory.out
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("trajectory.out"));
  EXPECT_EQ(FileContent(folder.path() / "r/result.json"), "an earlier result");
  EXPECT_THAT(NamesIn(folder.path() / "r"), ElementsAre("report.json", "result.json"));
  const Json report = Json::parse(FileContent(folder.path() / "r/report.json"));
  EXPECT_EQ(report["error"]["kind"], "output");
}

TEST(CliOutput, AnUnwritableStandardOutputIsAnError) {
  ProgramOptions options;
  options.arguments = {"check", ShortFlight().string()};
  options.out_file = "/dev/full";
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "dn check: error: the standard output cannot be written\n");
}

class Interrupting : public ::testing::TestWithParam<int> {};

TEST_P(Interrupting, EndsWith130AndNoResult) {
  const TempFolder folder;
  ProgramOptions options;
  options.arguments = CalibrateInto(folder.path() / "r");
  options.signal = GetParam();
  options.signal_after = "dn calibrate: reading";
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 130);
  EXPECT_THAT(run.err, HasSubstr("dn calibrate: error: interrupted; no result was written\n"));
  EXPECT_THAT(NamesIn(folder.path() / "r"), ElementsAre("report.json"));
  const Json report = Json::parse(FileContent(folder.path() / "r/report.json"));
  EXPECT_EQ(report["error"]["kind"], "interrupted");
}

INSTANTIATE_TEST_SUITE_P(Cli, Interrupting, ::testing::Values(SIGINT, SIGTERM));

TEST(CliOutput, InterruptedSimulationLeavesNoFlight) {
  const TempFolder folder;
  ProgramOptions options;
  options.arguments = {"simulate", "lar3", "--out", (folder.path() / "f").string()};
  options.signal = SIGINT;
  options.signal_after = "dn simulate: ";
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 130);
  EXPECT_THAT(NamesIn(folder.path() / "f"), ElementsAre("report.json"));
}

}  // namespace dn::testing::apps_test
