#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <map>

#include "damaged_flight.h"

namespace dn::testing::apps_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

/// Returns the contents of all files of a folder by name.
std::map<std::string, std::string> FolderContents(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) contents[entry.path().string()] = FileContent(entry.path());
  }
  return contents;
}

void ExpectRefused(const std::vector<std::string>& arguments, const fs::path& untouched) {
  const auto before = FolderContents(untouched);
  const ProgramRun run = RunProgram(arguments);
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_THAT(run.err, HasSubstr("--out "));
  EXPECT_EQ(FolderContents(untouched), before);
}

TEST(CliOutputFolderManyRuns, IsNeverTheFlightFolder) {
  const DamagedFlight flight;
  const TempFolder links;
  fs::create_directory_symlink(flight.path(), links.path() / "link");
  const std::string input = flight.path().string();
  const std::vector<fs::path> outs{flight.path(), flight.path() / ".", flight.path() / "lidar/..",
                                   links.path() / "link", flight.path() / "lidar"};
  for (const fs::path& out : outs) {
    SCOPED_TRACE(out);
    for (const char* command : {"check", "smooth", "calibrate"}) {
      ExpectRefused({command, input, "--out", out.string()}, flight.path());
    }
  }
  ExpectRefused({"smooth", (links.path() / "link").string(), "--out", input}, flight.path());
}

TEST(CliOutputFolder, IsNeverAFolderOfTheData) {
  const DamagedFlight flight;
  const fs::path data = flight.path().parent_path() / "data";
  fs::create_directory(data);
  fs::rename(flight.path() / "IMU.txt", data / "IMU.txt");
  flight.Replace("flight.yaml", "file: \"IMU.txt\"", "file: ../data/IMU.txt");
  ExpectRefused({"smooth", flight.path().string(), "--out", data.string()}, data);
}

TEST(CliOutputFolder, IsNeverAnotherFlight) {
  const TempFolder folder;
  folder.Write("f/flight.yaml", "name: of the user\n");
  const std::string out = (folder.path() / "f").string();
  ExpectRefused({"calibrate", ShortFlight().string(), "--out", out}, folder.path());
  ExpectRefused({"simulate", ShortScenario().string(), "--out", out}, folder.path());
}

TEST(CliOutputFolder, ASimulatedFlightMayBeSimulatedAnew) {
  const DamagedFlight flight;
  flight.Write("notes.txt", "of the user");
  flight.Write("lidar/9_9.txt", "of the user");
  const ProgramRun run = RunProgram(
      {"simulate", ShortScenario().string(), "--seed", "9", "--out", flight.path().string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(flight.Read("IMU.txt"), FileContent(ShortFlight() / "IMU.txt"));
  EXPECT_EQ(flight.Read("notes.txt"), "of the user");
  EXPECT_EQ(flight.Read("lidar/9_9.txt"), "of the user");
}

TEST(CliOutputFolder, HoldsNothingOfAnEarlierResultBesideAnError) {
  const TempFolder folder;
  fs::copy(CalibrateResult(), folder.path() / "r", fs::copy_options::recursive);
  folder.Write("r/notes.txt", "of the user");
  const std::string out = (folder.path() / "r").string();
  EXPECT_EQ(RunProgram({"smooth", (folder.path() / "absent").string(), "--out", out}).exit_code, 2);
  EXPECT_THAT(NamesIn(out), ElementsAre("notes.txt", "report.json"));
  const Json report = Json::parse(FileContent(folder.path() / "r/report.json"));
  EXPECT_EQ(report["error"]["kind"], "configuration");
  EXPECT_EQ(report["files"], Json({"report.json"}));
}

TEST(CliOutputFolder, ReportListsWhatWasWritten) {
  const Json report = Json::parse(FileContent(CalibrateResult() / "report.json"));
  std::vector<std::string> listed = report["files"];
  std::sort(listed.begin(), listed.end());
  EXPECT_EQ(listed, NamesIn(CalibrateResult()));
}

TEST(CliOutputFolder, AReportCannotNameFilesElsewhere) {
  const TempFolder folder;
  folder.Write("outside.txt", "of the user");
  folder.Write("r/report.json",
               R"({"schema": "dn.report/1", "files": ["../outside.txt", 3, "", "report.json"]})");
  const std::string out = (folder.path() / "r").string();
  EXPECT_EQ(RunProgram({"smooth", (folder.path() / "absent").string(), "--out", out}).exit_code, 2);
  EXPECT_EQ(FileContent(folder.path() / "outside.txt"), "of the user");
}

TEST(CliOutputFolderManyRuns, ADamagedReportIsIgnored) {
  const std::string nested = std::string(150'000, '[') + std::string(150'000, ']');
  const std::string reports[] = {
      "",
      "[",
      "[]",
      std::string(1'000'000, '['),
      R"({"schema": "dn.report/1", "files": )" + nested + "}",
      R"({"schema": "dn.report/1", "files": ["notes.txt"], "files": ["notes.txt"]})",
      R"({"schema": ["dn.report/1"], "files": ["notes.txt"]})",
      R"({"schema": "dn.report/1", "files": {"notes.txt": "notes.txt"}})",
      R"({"schema": "dn.report/1", "files": [".hidden", "a/b/notes.txt", ["notes.txt"], null]})",
      R"({"schema": "dn.report/1"})"};
  for (const std::string& report : reports) {
    SCOPED_TRACE(report.substr(0, 80));
    const TempFolder folder;
    folder.Write("r/report.json", report);
    folder.Write("r/notes.txt", "of the user");
    folder.Write("r/.hidden", "of the user");
    const ProgramRun run =
        RunProgram({"check", ShortFlight().string(), "--out", (folder.path() / "r").string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(FileContent(folder.path() / "r/notes.txt"), "of the user");
    EXPECT_EQ(FileContent(folder.path() / "r/.hidden"), "of the user");
  }
}

TEST(CliOutputFolder, APlantedJournalIsRefusedAndTouchesNothing) {
  const TempFolder folder;
  folder.Write("bashrc", "of the user");
  folder.Write("r/.dn-staging-abcdef/.commit", "../bashrc\n");
  folder.Write("r/.dn-staging-abcdef/bashrc", "evil");
  const ProgramRun run =
      RunProgram({"check", ShortFlight().string(), "--out", (folder.path() / "r").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("r/.dn-staging-abcdef/.commit is not the journal of a run"));
  EXPECT_EQ(FileContent(folder.path() / "bashrc"), "of the user");
}

TEST(CliOutputFolder, AnInputThatIsAnEarlierResultIsKept) {
  const TempFolder folder;
  fs::copy(SmoothResult(), folder.path() / "r", fs::copy_options::recursive);
  const std::string out = (folder.path() / "r").string();
  ExpectRefused({"calibrate", ShortFlight().string(), "--method", "gh", "--trajectory",
                 out + "/trajectory.out", "--out", out},
                folder.path());
}

TEST(CliOutputFolder, IsHeldByOneRunAtATime) {
  const TempFolder folder;
  const std::string out = (folder.path() / "r").string();
  ProgramRun second;
  ProgramOptions first;
  first.arguments = {"calibrate", ShortFlight().string(), "--out", out};
  first.signal_after = "dn calibrate: reading";
  first.at_signal = [&](int child) {
    ::kill(child, SIGSTOP);
    second = RunProgram({"smooth", ShortFlight().string(), "--out", out});
    ::kill(child, SIGCONT);
  };
  EXPECT_EQ(RunProgram(first).exit_code, 0);
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_THAT(second.err, HasSubstr("another run is writing into " + out));
  EXPECT_THAT(NamesIn(out), Contains("result.json"));
  EXPECT_THAT(NamesIn(out), Not(Contains("smooth.json")));
}

TEST(CliOutputFolder, OfAKilledRunIsSweptByTheNext) {
  const TempFolder folder;
  const std::string out = (folder.path() / "r").string();
  ProgramOptions killed;
  killed.arguments = {"calibrate", ShortFlight().string(), "--out", out};
  killed.signal = SIGKILL;
  killed.signal_after = "dn calibrate: reading";
  EXPECT_EQ(RunProgram(killed).signal, SIGKILL);
  EXPECT_EQ(NamesIn(out).size(), 1U);
  EXPECT_EQ(RunProgram({"check", ShortFlight().string(), "--out", out}).exit_code, 0);
  EXPECT_THAT(NamesIn(out), ElementsAre("config.resolved.yaml", "report.html", "report.json"));
}

TEST(CliOutputFolder, AFolderInTheWayOfAFileLeavesNothingElse) {
  const TempFolder folder;
  folder.Write("r/result.json/inside.txt", "of the user");
  const ProgramRun run =
      RunProgram({"calibrate", ShortFlight().string(), "--out", (folder.path() / "r").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("has the name of a result file"));
  EXPECT_THAT(NamesIn(folder.path() / "r"), ElementsAre("report.json", "result.json"));
}

TEST(CliOutputFolder, TheTrajectoryOfACalibrationIsNoInputOfTheGaussHelmertAdjustment) {
  const TempFolder folder;
  const auto calibrate = [&](const fs::path& trajectory) {
    return RunProgram({"calibrate", ShortFlight().string(), "--method", "gh", "--trajectory",
                       trajectory.string(), "--out", (folder.path() / "r").string()});
  };
  const ProgramRun run = calibrate(CalibrateResult() / "trajectory.out");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("dn smooth " + ShortFlight().string()));
  EXPECT_THAT(run.err, HasSubstr("trajectory.out"));
  EXPECT_EQ(calibrate(SmoothResult() / "trajectory.out").exit_code, 0);
}

TEST(CliOutputFolder, ANameReachesNoInterpreter) {
  const DamagedFlight flight;
  const std::string yaml = flight.Read("flight.yaml");
  const std::string touched = (flight.path() / "touched").string();
  flight.Write("flight.yaml",
               "name: \"a\\n!touch " + touched + "\"\n" + yaml.substr(yaml.find('\n') + 1));
  const ProgramRun run = flight.Run("smooth");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("name: contains a line break or another control character"));
  EXPECT_FALSE(fs::exists(touched));
}

}  // namespace dn::testing::apps_test
