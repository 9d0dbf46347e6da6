#include <dn/effects/effect_table.h>
#include <dn/files/flight_config.h>
#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::StartsWith;
namespace fs = std::filesystem;

TEST(CliGap, WritesItsFiles) {
  EXPECT_THAT(NamesIn(GapResult()), IsSupersetOf({"config.resolved.yaml", "flight.adapted.yaml",
                                                  "gap.json", "report.html", "report.json",
                                                  "summary.txt", "trajectory.out", "twin.yaml"}));
  EXPECT_THAT(FileContent(GapResult() / "summary.txt"), StartsWith("flight short: "));
  const Json report = Json::parse(FileContent(GapResult() / "report.json"));
  EXPECT_EQ(report["seed"], 5);
  EXPECT_TRUE(report["error"].is_null());
}

TEST(CliGap, ScreensEveryEffectThatItMay) {
  const Json gap = Json::parse(FileContent(GapResult() / "gap.json"));
  EXPECT_EQ(gap["schema"], "dn.gap/1");
  EXPECT_EQ(gap["flight"], "short");
  std::vector<std::string> screened;
  for (const Json& cause : gap["causes"]) screened.push_back(cause["effect"]);
  EXPECT_THAT(screened, IsSupersetOf({"gnss_lever_arm", "lidar_time_offset"}));
  EXPECT_THAT(screened, ::testing::Not(::testing::Contains("gravity_disturbance")));
  for (const std::string& effect : screened) EXPECT_NE(FindEffect(effect), nullptr) << effect;
}

TEST(CliGap, AveragesTheBoresightOverAllHypotheses) {
  const Json gap = Json::parse(FileContent(GapResult() / "gap.json"));
  EXPECT_EQ(gap["outside"]["prior"], 0.2);
  const Json& averaged = gap["boresight_averaged"];
  for (std::size_t k = 0; k < 3; ++k) {
    const double sigma = averaged["sigma_deg"][k];
    EXPECT_GT(sigma, 0.0);
    EXPECT_NEAR(averaged["covariance_deg2"][k][k].get<double>(), sigma * sigma, 1e-12);
    EXPECT_TRUE(averaged["angles_deg"][k].is_number());
  }
}

TEST(CliGap, TheAdaptedFlightCalibratesFromWhereItLiesAndFromTheFlightFolder) {
  const TempFolder folder;
  const std::string adapted = (GapResult() / "flight.adapted.yaml").string();
  const ProgramRun there =
      RunProgram({"calibrate", adapted, "--out", (folder.path() / "there").string()});
  // If the diagnosis leaves a discrepancy unexplained, the adapted flight stays contradicted.
  const int expected = ReadFlightConfig(adapted).unexplained.empty() ? 0 : 1;
  EXPECT_EQ(there.exit_code, expected) << there.err;
  fs::copy(ShortFlight(), folder.path() / "copy", fs::copy_options::recursive);
  fs::remove(folder.path() / "copy/flight.yaml");
  folder.Write("copy/flight.yaml", WithoutLines(FileContent(adapted), "unexplained:"));
  EXPECT_EQ(ReadFlightConfig(folder.path() / "copy").folder, folder.path() / "copy");
  const ProgramRun copied = RunProgram({"calibrate", (folder.path() / "copy").string(), "--out",
                                        (folder.path() / "result").string()});
  EXPECT_EQ(copied.exit_code, 0) << copied.err;
  const auto angles = [&](const char* result) {
    const Json json = Json::parse(FileContent(folder.path() / result / "result.json"));
    return json["boresight"]["angles_deg"];
  };
  EXPECT_EQ(angles("there"), angles("result"));
}

TEST(CliGap, TheTwinCanBeSimulated) {
  const TempFolder folder;
  const ProgramRun run = RunProgram({"simulate", (GapResult() / "twin.yaml").string(), "--out",
                                     (folder.path() / "twin").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 strips, 400 pairs"));
}

TEST(CliGap, ItsResultsAreNotOverwrittenByWhatReadsThem) {
  const std::string out = GapResult().string();
  const ProgramRun run = RunProgram({"calibrate", out + "/flight.adapted.yaml", "--out", out});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("contains an earlier result"));
  EXPECT_TRUE(fs::exists(GapResult() / "gap.json"));
}

void ExpectWrongUsage(const std::vector<std::string>& options, const std::string& message) {
  const TempFolder folder;
  std::vector<std::string> arguments{"gap", ShortFlight().string(), "--out",
                                     (folder.path() / "gap").string()};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const ProgramRun run = RunProgram(arguments);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr(message));
}

TEST(CliGap, RefusesWhatContradictsItself) {
  ExpectWrongUsage({"--quick", "--limits"}, "--limits");
  ExpectWrongUsage({"--quick", "--screen-only"}, "--screen-only");
  ExpectWrongUsage({"--alpha", "0"}, "--alpha");
  ExpectWrongUsage({"--alpha", "1.5"}, "alpha");
  ExpectWrongUsage({"--outside", "1"}, "--outside");
  ExpectWrongUsage({"--outside", "-0.1"}, "--outside");
  ExpectWrongUsage({"--effects", "gnss_lever_arm,moonlight"}, "moonlight");
  ExpectWrongUsage({"--without", "moonlight"}, "moonlight");
}

}  // namespace dn::testing::apps_test
