// Input that asks for unlimited time or memory is refused, and the message states the bound.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "damaged_flight.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

// Memory of a program that starts and refuses; the libraries alone map half of it.
constexpr long kLittleMemory = 1L << 30;

ProgramRun RunWithin(const std::vector<std::string>& arguments) {
  ProgramOptions options;
  options.arguments = arguments;
  options.max_memory_bytes = kLittleMemory;
  return RunProgram(options);
}

TEST(CliLimits, AKeyWithoutEnd) {
  std::string key = "a";
  for (int i = 0; i < 20000; ++i) key += ".a";
  const ProgramRun run = RunWithin({"check", ShortFlight(), "--set", key + "=1"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("at most 200"));
}

TEST(CliLimits, ASweepWithoutEnd) {
  const TempFolder folder;
  std::string values = "0";
  for (int i = 1; i < 150000; ++i) values += "," + std::to_string(i);
  folder.Write("s.yaml", "base: lar3\nsweep:\n  pairs.count: [" + values + "]\n");
  const ProgramRun run =
      RunWithin({"study", "--sweep", folder.path() / "s.yaml", "--out", folder.path() / "o"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("makes more than 10000 designs"));
  EXPECT_THAT(run.err, HasSubstr("s.yaml:3"));
}

TEST(CliLimits, ASweepOfWhatIsNoUnknown) {
  const TempFolder folder;
  folder.Write("s.yaml", "base: lar3\nsweep:\n  pairs.count: [100]\nestimate: [foo]\n");
  const ProgramRun run =
      RunProgram({"study", "--sweep", folder.path() / "s.yaml", "--out", folder.path() / "o"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("unknown name 'foo'; did you mean"));
  EXPECT_THAT(run.err, HasSubstr("s.yaml:4"));
}

TEST(CliLimits, ProcessesWithoutEnd) {
  const DamagedFlight flight;
  std::string processes;
  for (int i = 0; i < 1000; ++i) processes += "{type: random_constant, sigma_deg_h: 1}, ";
  const ProgramRun run =
      RunWithin({"calibrate", flight.path().string(), "--set",
                 "imu.gyro.processes=[" + processes + "]", "--out", flight.out().string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("imu.gyro.processes: has 1000 elements, at most 20"));
}

TEST(CliLimits, PulsesWithoutEnd) {
  const TempFolder folder;
  const ProgramRun run = RunWithin(
      {"simulate", ShortScenario(), "--set", "strips=true", "--set", "lidar.pulse_rate_hz=1e7",
       "--set", "plan.lines=[[0, 0, 100000, 0, 1000, 50], [100000, 0, 0, 0, 1000, 50]]", "--out",
       folder.path() / "f"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("the number of pulses"));
  EXPECT_THAT(run.err, HasSubstr("at most 5e+09"));
}

TEST(CliLimits, WhatNeedsLessMemoryIsThatOfTheCommand) {
  if (!kMemoryCanBeLimited) GTEST_SKIP() << "the address sanitizer needs all address space";
  const TempFolder folder;
  ProgramOptions options;
  options.max_memory_bytes = kLittleMemory;
  options.arguments = {"simulate", ShortScenario(),       "--set", "imu.rate_hz=2000",
                       "--set",    "plan.warm_up_s=4000", "--out", folder.path() / "f"};
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("out of memory; lower pairs.count, imu.rate_hz"));
}

TEST(CliLimits, ALargeFileThatIsNoDataNeedsLittleMemory) {
  const TempFolder folder;
  for (const char* name : {"IMU.txt", "GPS.txt"}) fs::copy(ShortFlight() / name, folder.path());
  std::string rows;
  for (int i = 0; i < 2000000; ++i) {
    rows += std::to_string(500000 + i % 1000) + ' ' + std::to_string(5200000 + i % 1000) +
            " 400 17 1 2 3\n";
  }
  folder.Write("cloud.txt", rows);
  ProgramOptions options;
  options.arguments = {"init", folder.path()};
  options.max_memory_bytes = kLittleMemory;
  const ProgramRun run = RunProgram(options);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("cloud.txt is not used: 7 columns"));
}

TEST(CliLimits, ALinkToItselfIsLeftOut) {
  const TempFolder folder;
  for (const char* name : {"IMU.txt", "GPS.txt"}) fs::copy(ShortFlight() / name, folder.path());
  fs::create_symlink("loop.txt", folder.path() / "loop.txt");
  fs::create_symlink("lidar", folder.path() / "lidar");
  const ProgramRun run = RunProgram({"init", folder.path()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("loop.txt is not used: "));
  fs::remove(folder.path() / "lidar");
  fs::create_directory(folder.path() / "strips");
  fs::create_symlink("1.las", folder.path() / "strips/1.las");
  EXPECT_THAT(RunProgram({"check", folder.path()}).err,
              HasSubstr("strips/1.las leads back to itself; it is ignored"));
}

}  // namespace dn::testing::apps_test
