#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "damaged_flight.h"

namespace dn::testing::apps_test {

using ::testing::AnyOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

ProgramOptions CalibrateInto(const TempFolder& folder) {
  ProgramOptions options;
  options.arguments = {"calibrate", ShortFlight().string(), "--out",
                       (folder.path() / "r").string()};
  return options;
}

void ExpectResult(const ProgramOptions& options, const TempFolder& folder, int exit_code) {
  EXPECT_EQ(RunProgram(options).exit_code, exit_code);
  const Json result = Json::parse(FileContent(folder.path() / "r/result.json"));
  EXPECT_EQ(result["schema"], "dn.result/1");
  EXPECT_TRUE(Json::accept(FileContent(folder.path() / "r/report.json")));
  for (const std::string& name : NamesIn(folder.path() / "r")) {
    EXPECT_EQ(FileContent(folder.path() / "r" / name).find("dn calibrate: "), std::string::npos);
  }
}

TEST(CliEnvironment, ErrorsThatNobodyCanReadLoseNoResult) {
  for (const char* where : {"/dev/full", "/dev/null"}) {
    const TempFolder folder;
    ProgramOptions options = CalibrateInto(folder);
    options.err_file = where;
    ExpectResult(options, folder, 0);
  }
}

TEST(CliEnvironmentManyRuns, ClosedStreamsLoseNoResult) {
  const std::vector<std::pair<std::vector<int>, int>> cases{{{STDERR_FILENO}, 0},
                                                            {{STDIN_FILENO, STDERR_FILENO}, 0},
                                                            {{STDOUT_FILENO}, 1},
                                                            {{0, 1, 2}, 1}};
  for (const auto& [streams, exit_code] : cases) {
    const TempFolder folder;
    ProgramOptions options = CalibrateInto(folder);
    options.closed_streams = streams;
    ExpectResult(options, folder, exit_code);
  }
}

TEST(CliEnvironment, NoTemporaryFolderIsNeeded) {
  setenv("TMPDIR", "/nonexistent", 1);
  const TempFolder folder;
  const ProgramOptions options = CalibrateInto(folder);
  ExpectResult(options, folder, 0);
  unsetenv("TMPDIR");
}

TEST(CliEnvironment, LittleMemoryIsAnErrorNotAnEndlessLoop) {
  if (!kMemoryCanBeLimited) GTEST_SKIP() << "memory cannot be limited under this sanitizer";
  for (const long megabytes : {100L, 150L, 200L, 250L, 300L, 400L, 600L}) {
    SCOPED_TRACE(megabytes);
    const TempFolder folder;
    ProgramOptions options = CalibrateInto(folder);
    options.max_memory_bytes = megabytes << 20;
    const ProgramRun run = RunProgram(options);
    EXPECT_EQ(run.signal, 0);
    EXPECT_THAT(run.exit_code, AnyOf(0, 1, 127));  // 127: the libraries cannot be loaded
    EXPECT_TRUE(run.exit_code != 1 || run.err.find("error: ") != std::string::npos);
  }
}

TEST(CliEnvironment, OneThreadIsOneThread) {
  const TempFolder folder;
  ProgramOptions options = CalibrateInto(folder);
  options.arguments.insert(options.arguments.end(), {"--threads", "1"});
  options.signal_after = "dn calibrate: writing";
  std::size_t threads = 0;
  options.at_signal = [&](int child) {
    threads = NamesIn("/proc/" + std::to_string(child) + "/task").size();
  };
  EXPECT_EQ(RunProgram(options).exit_code, 0);
  EXPECT_EQ(threads, 1U);
}

TEST(CliEnvironmentManyRuns, ThreadsThatCannotBeStartedAreDoneWithout) {
  for (const long threads : {0L, 1L, 2L}) {
    SCOPED_TRACE(threads);
    const TempFolder folder;
    fs::permissions(folder.path(), fs::perms::all);
    ProgramOptions options = CalibrateInto(folder);
    options.arguments.insert(options.arguments.end(), {"--threads", "4"});
    options.max_threads = threads;
    const ProgramRun run = RunProgram(options);
    if (run.exit_code == 127) GTEST_SKIP() << "nobody cannot run " << DN_PROGRAM;
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("of 4 threads can be started"));
    EXPECT_TRUE(Json::accept(FileContent(folder.path() / "r/result.json")));
  }
}

TEST(CliEnvironment, FileSizeLimitIsAnErrorOfWriting) {
  const TempFolder folder;
  ProgramOptions options = CalibrateInto(folder);
  options.max_file_bytes = 1000;
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("error: "));
  EXPECT_LE(NamesIn(folder.path() / "r").size(), 1U);
}

TEST(CliEnvironment, SizesThatNoMemoryHoldsAreRefused) {
  const TempFolder folder;
  const std::string scenario = FileContent(ShortScenario());
  const auto replaced = [&](const std::string& key, const std::string& value) {
    const std::size_t at = scenario.find(key + ":");
    EXPECT_NE(at, std::string::npos) << key;
    const std::size_t end = scenario.find_first_of(",}\n", at);
    return scenario.substr(0, at) + key + ": " + value + scenario.substr(end);
  };
  const std::vector<std::pair<const char*, const char*>> cases{
      {"warm_up_s", "1e6"}, {"count", "999999999"}, {"relief_m", "1e9"}};
  for (const auto& [key, value] : cases) {
    folder.Write("s.yaml", replaced(key, value));
    const ProgramRun run = RunProgram(
        {"simulate", (folder.path() / "s.yaml").string(), "--out", (folder.path() / "f").string()});
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_THAT(run.err, HasSubstr(key));
    EXPECT_THAT(run.err, HasSubstr("at most"));
  }
}

TEST(CliEnvironment, ANodeRateThatNoMemoryHoldsIsRefused) {
  const DamagedFlight flight;
  flight.Replace("flight.yaml", "node_rate_hz: auto", "node_rate_hz: 1e20");
  const ProgramRun run = flight.Run("calibrate");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("network.node_rate_hz"));
}

}  // namespace dn::testing::apps_test
