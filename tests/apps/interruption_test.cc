#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <tuple>

#include "damaged_flight.h"

namespace dn::testing::apps_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// Provides a program named gnuplot that does not end by itself. While this object lives, it is the
/// first one in PATH.
class HangingGnuplot {
 public:
  HangingGnuplot() : path_(std::getenv("PATH")) {
    folder_.Write("gnuplot", "#!/bin/sh\necho $$ >\"${0%/*}/pid\"; exec sleep 60\n");
    fs::permissions(folder_.path() / "gnuplot", fs::perms::owner_all);
    setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~HangingGnuplot() { setenv("PATH", path_.c_str(), 1); }
  // A zombie process has an empty command line.
  bool Runs() const {
    std::ifstream in("/proc/" + std::to_string(std::stoi(FileContent(pid_file()))) + "/cmdline");
    return in.get() != std::ifstream::traits_type::eof();
  }
  fs::path pid_file() const { return folder_.path() / "pid"; }
  HangingGnuplot(const HangingGnuplot&) = delete;
  HangingGnuplot& operator=(const HangingGnuplot&) = delete;

 private:
  TempFolder folder_;
  std::string path_;
};

void ExpectInterrupted(const ProgramRun& run, const fs::path& out) {
  EXPECT_EQ(run.exit_code, 130) << run.err;
  EXPECT_LT(run.end_after_signal_s, 2.0);  // about 1 s on a busy machine
  EXPECT_THAT(run.err, HasSubstr("error: interrupted; no result was written\n"));
  EXPECT_THAT(NamesIn(out), ElementsAre("report.json"));
  const Json report = Json::parse(FileContent(out / "report.json"));
  EXPECT_EQ(report["error"]["kind"], "interrupted");
  EXPECT_EQ(report["schema"], "dn.report/1");
}

class Interruption : public ::testing::TestWithParam<std::tuple<int, const char*>> {};

TEST_P(Interruption, EndsEveryStageWithinASecond) {
  const TempFolder folder;
  ProgramOptions options;
  options.arguments = {"calibrate", ShortFlight().string(), "--out",
                       (folder.path() / "r").string()};
  options.signal = std::get<0>(GetParam());
  options.signal_after = std::string("dn calibrate: ") + std::get<1>(GetParam());
  ExpectInterrupted(RunProgram(options), folder.path() / "r");
}

INSTANTIATE_TEST_SUITE_P(Cli, Interruption,
                         ::testing::Combine(::testing::Values(SIGINT, SIGTERM, SIGHUP),
                                            ::testing::Values("reading", "alignment", "INS/GNSS",
                                                              "lidar")));

TEST(CliInterruption, EndsAGnuplotThatHangs) {
  const HangingGnuplot gnuplot;
  const TempFolder folder;
  ProgramOptions options;
  options.arguments = {"smooth", ShortFlight().string(), "--out", (folder.path() / "r").string()};
  options.signal = SIGTERM;
  options.signal_after = "dn smooth: writing";
  ExpectInterrupted(RunProgram(options), folder.path() / "r");
}

TEST(CliInterruption, ASecondSignalEndsAtOnce) {
  const HangingGnuplot gnuplot;
  const TempFolder folder;
  ProgramOptions options;
  options.arguments = {"smooth", ShortFlight().string(), "--out", (folder.path() / "r").string()};
  options.signal_after = "dn smooth: writing";
  options.at_signal = [&](int child) {
    while (!fs::exists(gnuplot.pid_file()) || FileContent(gnuplot.pid_file()).empty())
      ::usleep(1000);
    ::kill(child, SIGINT);
    ::kill(child, SIGTERM);
  };
  ExpectInterrupted(RunProgram(options), folder.path() / "r");
  for (int i = 0; i < 1000 && gnuplot.Runs(); ++i) ::usleep(1000);
  EXPECT_FALSE(gnuplot.Runs());
}

TEST(CliInterruptionManyRuns, EndsASimulation) {
  for (const char* stage : {"trajectory", "imu", "writing"}) {
    SCOPED_TRACE(stage);
    const TempFolder folder;
    ProgramOptions options;
    options.arguments = {"simulate", "lar3", "--out", (folder.path() / "f").string()};
    options.signal = SIGINT;
    options.signal_after = std::string("dn simulate: ") + stage;
    ExpectInterrupted(RunProgram(options), folder.path() / "f");
  }
}

TEST(CliInterruption, EndsAPointCloud) {
  const TempFolder folder;
  folder.Write("clouds.yaml", FileContent(ShortScenario()) + "strips: true\n");
  ProgramOptions options;
  options.arguments = {"simulate", (folder.path() / "clouds.yaml").string(), "--out",
                       (folder.path() / "f").string()};
  options.signal = SIGINT;
  options.signal_after = "dn simulate: strip 1";
  ExpectInterrupted(RunProgram(options), folder.path() / "f");
}

TEST(CliInterruption, APipeIsNoInput) {
  const DamagedFlight flight;
  const fs::path pipe = flight.path().parent_path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(RunProgram({"allan", pipe.string(), "--rate", "200", "--out", flight.out().string()})
                .exit_code,
            1);
  EXPECT_EQ(RunProgram({"simulate", pipe.string(), "--out", flight.out().string()}).exit_code, 2);
  fs::remove(flight.path() / "flight.yaml");
  ASSERT_EQ(::mkfifo((flight.path() / "flight.yaml").c_str(), 0600), 0);
  EXPECT_EQ(flight.Run("smooth").exit_code, 2);
}

}  // namespace dn::testing::apps_test
