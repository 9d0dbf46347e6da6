#include <dn/files/flight_config.h>
#include <dn/files/truth.h>
#include <dn/geo/trajectory.h>
#include <dn/lidar/strip_io.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

ProgramRun SimulateInto(const fs::path& folder, const fs::path& scenario, const char* seed) {
  return RunProgram({"simulate", scenario.string(), "--seed", seed, "--out", folder.string()});
}

TEST(CliSimulate, WritesAFlightFolder) {
  EXPECT_THAT(NamesIn(ShortFlight()),
              ElementsAre("GPS.txt", "IMU.txt", "config.resolved.yaml", "flight.yaml", "lidar",
                          "reference.out", "report.html", "report.json", "truth.yaml"));
  EXPECT_THAT(NamesIn(ShortFlight() / "lidar"), Not(IsEmpty()));
}

TEST(CliSimulate, SaysWhatItMade) {
  const TempFolder folder;
  const ProgramRun run = SimulateInto(folder.path() / "f", ShortScenario(), "3");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("flight short: "));
  EXPECT_THAT(run.out, HasSubstr("2 strips, 400 pairs, seed 3"));
  EXPECT_THAT(run.err, HasSubstr("dn simulate: "));
}

TEST(CliSimulate, TheSameSeedGivesTheSameBytesAnotherOneDoesNot) {
  const TempFolder folder;
  ASSERT_EQ(SimulateInto(folder.path() / "same", ShortScenario(), "3").exit_code, 0);
  ASSERT_EQ(SimulateInto(folder.path() / "other", ShortScenario(), "4").exit_code, 0);
  for (const char* name : {"IMU.txt", "GPS.txt", "flight.yaml", "truth.yaml", "reference.out"}) {
    EXPECT_EQ(FileContent(folder.path() / "same" / name), FileContent(ShortFlight() / name))
        << name;
  }
  for (const std::string& name : NamesIn(ShortFlight() / "lidar")) {
    EXPECT_EQ(FileContent(folder.path() / "same/lidar" / name),
              FileContent(ShortFlight() / "lidar" / name));
  }
  EXPECT_NE(FileContent(folder.path() / "other/IMU.txt"), FileContent(ShortFlight() / "IMU.txt"));
}

TEST(CliSimulate, TruthStaysInItsOwnFile) {
  const TempFolder folder;
  const std::string scenario = FileContent(ShortScenario()) +
                               "effects:\n  - {effect: gnss_lever_arm, value: [0.123, 0, 0]}\n"
                               "  - {effect: lidar_time_offset, value: 0.000456}\n";
  folder.Write("effects.yaml", scenario);
  const fs::path flight = folder.path() / "f";
  ASSERT_EQ(SimulateInto(flight, folder.path() / "effects.yaml", "1").exit_code, 0);

  const FlightConfig config = ReadFlightConfig(flight);
  EXPECT_EQ(config.lidar->mounting.boresight_rad, Eigen::Vector3d::Zero());
  EXPECT_EQ(config.gnss->lever_arm_b_m, Eigen::Vector3d(0.4, -0.1, -1.1));
  for (const char* name : {"flight.yaml", "config.resolved.yaml"}) {
    const std::string text = FileContent(flight / name);
    for (const char* leak : {"0.35", "0.03,", "0.123", "0.523", "0.000456", "effect"}) {
      EXPECT_THAT(text, Not(HasSubstr(leak))) << name;
    }
  }
  const std::string truth = FileContent(flight / "truth.yaml");
  EXPECT_THAT(truth, HasSubstr("gnss_lever_arm_m: [0.523, -0.1, -1.1]"));
  EXPECT_THAT(truth, HasSubstr("{effect: lidar_time_offset, value: 0.000456}"));
  const auto boresight_deg = ReadTrueBoresightDeg(flight);
  ASSERT_TRUE(boresight_deg.has_value());
  EXPECT_TRUE(boresight_deg->isApprox(Eigen::Vector3d(0.2, 0.03, 0.35), 1e-12));
}

/// Returns the root mean square of a strip's heights above a level plain, m.
double RmsHeight(const fs::path& file) {
  const auto reader = OpenStrip(file);
  double squares = 0.0;
  for (StripCloud points; reader->Next(&points);) {
    for (const Eigen::Vector3d& p_m : points.p_c) squares += p_m.z() * p_m.z();
  }
  return std::sqrt(squares / static_cast<double>(reader->points().value()));
}

TEST(CliSimulate, PointCloudsLieOnTheGroundWithTheTrueBoresight) {
  const TempFolder folder;
  std::string scenario = FileContent(ShortScenario());
  const std::size_t terrain = scenario.find("terrain:");
  scenario.replace(terrain, scenario.find('\n', terrain) - terrain,
                   "terrain: {kind: flat, roughness_m: 0}");
  const std::string key = "gsd_m: 0.2";
  scenario.replace(scenario.find(key), key.size(), key + "\n  pulse_rate_hz: 1000");
  folder.Write("clouds.yaml", scenario + "strips: true\n");
  const fs::path flight = folder.path() / "f", clouds = folder.path() / "clouds";
  const ProgramRun run = RunProgram({"simulate", (folder.path() / "clouds.yaml").string(),
                                     "--noise-free", "--out", flight.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr(" points\n"));
  EXPECT_THAT(NamesIn(flight / "strips"), ElementsAre("1.las", "2.las"));

  const ProgramRun check =
      RunProgram({"check", flight.string(), "--out", (folder.path() / "checked").string()});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("2.las: "));
  const ProgramRun georef =
      RunProgram({"georef", flight.string(), "--boresight", "0.2,0.03,0.35", "--trajectory",
                  (flight / "reference.out").string(), "--out", clouds.string()});
  ASSERT_EQ(georef.exit_code, 0) << georef.err;
  for (const char* name : {"strips/1.las", "strips/2.las"}) {
    EXPECT_LT(RmsHeight(clouds / name), 0.01) << name;  // the trajectory has 50 Hz
    EXPECT_GT(RmsHeight(flight / name), 0.1) << name;
  }
}

TEST(CliSimulate, AKeyOfTheScenarioIsChangedForThisRun) {
  const TempFolder folder;
  const auto simulate = [&](const std::string& change) {
    return RunProgram({"simulate", ShortScenario().string(), "--set", change, "--out",
                       (folder.path() / "f").string()});
  };
  const ProgramRun run = simulate("pairs.count=123");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 strips, 123 pairs"));
  const ProgramRun unknown = simulate("pairs.counts=123");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("unknown key 'counts'"));
  const ProgramRun none = simulate("123");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("write for example strips=true"));
}

TEST(CliSimulate, AScenarioWithAnUnknownKeyIsRefused) {
  const TempFolder folder;
  folder.Write("wrong.yaml", FileContent(ShortScenario()) + "pears: {count: 4}\n");
  const ProgramRun run = SimulateInto(folder.path() / "f", folder.path() / "wrong.yaml", "1");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("unknown key 'pears'; did you mean 'pairs'?"));
  EXPECT_THAT(run.err, HasSubstr("wrong.yaml:"));
}

}  // namespace dn::testing::apps_test
