#include <dn/files/truth.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "load_json.h"
#include "run_program.h"
#include "strip_scenario.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// Two flights of one scanner, and their calibration, which is made once.
class CliCalibrateFlights : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    for (const char* seed : {"31", "32"}) {
      RunProgram({"simulate", ShortScenario().string(), "--seed", seed, "--out",
                  (folder_->path() / seed).string(), "--set", std::string("name=day ") + seed});
    }
    run_ = new ProgramRun(Calibrate("fleet", {"--at-once", "2"}));
  }
  static void TearDownTestSuite() {
    delete run_;
    delete folder_;
  }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }

  static ProgramRun Calibrate(const std::string& out, const std::vector<std::string>& more = {}) {
    return Calibrate({Path("31").string(), Path("32").string()}, out, more);
  }
  static ProgramRun Calibrate(const std::vector<std::string>& flights, const std::string& out,
                              const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"calibrate"};
    arguments.insert(arguments.end(), flights.begin(), flights.end());
    arguments.insert(arguments.end(), {"--threads", "2", "--out", Path(out).string()});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  static Json Result(const std::string& out) { return LoadJson(Path(out) / "result.json"); }

  inline static TempFolder* folder_ = nullptr;
  inline static ProgramRun* run_ = nullptr;
};

TEST_F(CliCalibrateFlights, GivesOneBoresightForAll) {
  ASSERT_EQ(run_->exit_code, 0) << run_->err;
  const Json result = Result("fleet");
  EXPECT_EQ(result["schema"], "dn.result/1");
  EXPECT_EQ(result["assessment"]["verdict"], "calibrated");
  ASSERT_EQ(result["flights"].size(), 2u);
  const auto truth_deg = ReadTrueBoresightDeg(Path("31"));
  ASSERT_TRUE(truth_deg.has_value());
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma = result["boresight"]["sigma_deg"][i];
    EXPECT_NEAR(result["boresight"]["angles_deg"][i], (*truth_deg)[static_cast<int>(i)],
                4.0 * sigma);
    for (const Json& flight : result["flights"]) EXPECT_LT(sigma, flight["sigma_deg"][i]);
    EXPECT_LT(result["boresight"]["shared_effects_sigma_deg"][i], sigma);
    EXPECT_EQ(result["forecast"]["constant"]["sigma_deg"][i], sigma);
  }
  EXPECT_TRUE(result["stability"]["stable"]);
  EXPECT_GT(result["stability"]["p_value"], 0.01);
  EXPECT_EQ(result["flights"][1]["flight"], "day 32");
  EXPECT_THAT(run_->out, HasSubstr("boresight of 2 flights"));
  EXPECT_THAT(FileContent(Path("fleet") / "report.html"), HasSubstr("Is the boresight stable?"));
}

TEST_F(CliCalibrateFlights, HasTheResultOfEachFlightAlone) {
  const Json alone = LoadJson(Path("fleet") / "day_31" / "result.json");
  const Json flight = Result("fleet")["flights"][0];
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(flight["angles_deg"][i], alone["boresight"]["angles_deg"][i], 1e-12);
    EXPECT_NEAR(flight["sigma_deg"][i], alone["boresight"]["sigma_deg"][i], 1e-9);
  }
  EXPECT_TRUE(fs::exists(Path("fleet") / "day_31" / "report.html"));
}

TEST_F(CliCalibrateFlights, CalibratesNoFlightTwice) {
  const fs::path file = Path("fleet") / "day_31" / "result.json";
  const auto before = fs::last_write_time(file);
  const Json result = Result("fleet");
  const ProgramRun again =
      Calibrate("fleet", {"--across", "[{unknown: boresight, random_walk_deg: 0.01}]"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(fs::last_write_time(file), before);
  EXPECT_EQ(LoadJson(Path("fleet") / "report.json")["counts"]["flights of earlier runs"], 2);
  const Json walk = Result("fleet");
  EXPECT_EQ(walk["across"], "random_walk");
  EXPECT_NEAR(walk["forecast"]["random_walk"]["step_sigma_deg"], 0.01, 1e-12);
  EXPECT_GT(walk["boresight"]["sigma_deg"][0], result["boresight"]["sigma_deg"][0]);
  EXPECT_EQ(Calibrate("fleet").exit_code, 0);
  Json same = Result("fleet");
  same["timing_s"] = result["timing_s"];
  EXPECT_EQ(same, result);
}

TEST_F(CliCalibrateFlights, CombinesResultFolders) {
  const std::vector<std::string> folders{(Path("fleet") / "day_31").string(),
                                         (Path("fleet") / "day_32").string()};
  const ProgramRun run = Calibrate(folders, "combined");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Result("combined")["boresight"], Result("fleet")["boresight"]);
}

TEST_F(CliCalibrateFlights, LeavesOutFlightsThatAreNotCalibrated) {
  const std::vector<std::string> folders{(Path("fleet") / "day_31").string(),
                                         Path("contradicted").string()};
  Json reduced = LoadJson(Path("fleet") / "day_32" / "reduced.json");
  reduced["verdict"] = "contradicted";
  reduced["reasons"] = {"the clock is late"};
  folder_->Write("contradicted/reduced.json", reduced.dump());
  const ProgramRun run = Calibrate(folders, "left_out");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("1 of 2 flights can be combined"));
  EXPECT_THAT(run.err, HasSubstr("contradicted: the clock is late"));
  const ProgramRun asked = Calibrate(folders, "left_out", {"--include-uncalibrated"});
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_EQ(Result("left_out")["assessment"]["verdict"], "contradicted");
  EXPECT_THAT(asked.err, HasSubstr("flight day 32 is contradicted"));
}

TEST_F(CliCalibrateFlights, NamesTheFlightOfAChange) {
  Json reduced = LoadJson(Path("fleet") / "day_32" / "reduced.json");
  reduced["angles_rad"][1] = reduced["angles_rad"][1].get<double>() + 0.01;
  folder_->Write("moved/reduced.json", reduced.dump());
  const ProgramRun run =
      Calibrate({(Path("fleet") / "day_31").string(), Path("moved").string()}, "changed");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("the boresight changed before flight day 32 (from t = "));
  const Json result = Result("changed");
  EXPECT_EQ(result["stability"]["likeliest_change"]["flight"], "day 32");
  EXPECT_FALSE(result["stability"]["stable"]);
}

TEST_F(CliCalibrateFlights, RefusesFlightsThatDoNotBelongTogether) {
  const std::string day = Path("31").string();
  const auto expect = [&](const std::vector<std::string>& flights,
                          const std::vector<std::string>& more, const char* text) {
    const ProgramRun run = Calibrate(flights, "refused", more);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_THAT(run.err, HasSubstr(text));
  };
  expect({day, day}, {}, "have the same data");
  expect({day, Path("32").string()}, {"--method", "gh"}, "without --method");
  expect({day, Path("nowhere").string()}, {}, "there is no flight folder");
  expect({day, Path("32").string()}, {"--across", "[lidar_range_offset]"},
         "'boresight' is missing");
  expect({day}, {"--across", "[boresight]"}, "are for several flights");
  Json reduced = LoadJson(Path("fleet") / "day_32" / "reduced.json");
  reduced["mounting"]["lidar_lever_arm_m"][0] = 3.0;
  folder_->Write("other/reduced.json", reduced.dump());
  expect({day, Path("other").string()}, {}, "differ in lidar.lever_arm_m");
}

TEST(CliFleetClouds, StripsOfEachFlightGetTheCommonBoresight) {
  const TempFolder folder;
  const auto in = [&](const std::string& name) { return (folder.path() / name).string(); };
  folder.Write("town.yaml", StripScenario("kind: built_up, roughness_m: 0.2"));
  for (const char* day : {"one", "two"}) {
    const ProgramRun simulate = RunProgram(
        {"simulate", in("town.yaml"), "--set", std::string("name=") + day, "--set",
         "pairs.count=200", "--seed", std::string(day) == "one" ? "5" : "6", "--out", in(day)});
    ASSERT_EQ(simulate.exit_code, 0) << simulate.err;
  }
  const ProgramRun run =
      RunProgram({"calibrate", in("one"), in("two"), "--georef", "--out", in("fleet")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json result = LoadJson(folder.path() / "fleet/result.json");
  for (const std::string day : {"one", "two"}) {
    EXPECT_THAT(run.out, HasSubstr("clouds of flight " + day + ": " + in("fleet/" + day)));
    const Json georef = LoadJson(folder.path() / "fleet" / day / "clouds/georef.json");
    EXPECT_EQ(georef["trajectory"], in("fleet/" + day + "/trajectory.out"));
    EXPECT_TRUE(fs::exists(in("fleet/" + day + "/clouds/strips/1.las")));
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(georef["boresight_deg"][i].get<double>(),
                  result["boresight"]["angles_deg"][i].get<double>(), 1e-9);
    }
  }
  // A result folder has no clouds, and a flight without strips is refused before it is calibrated.
  const ProgramRun results =
      RunProgram({"calibrate", in("fleet/one"), in("two"), "--georef", "--out", in("other")});
  EXPECT_EQ(results.exit_code, 2);
  EXPECT_THAT(results.err, HasSubstr("is the result of a flight, without its point clouds"));
  fs::remove_all(in("two") + "/strips");
  const ProgramRun none =
      RunProgram({"calibrate", in("one"), in("two"), "--georef", "--out", in("other")});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_FALSE(fs::exists(in("other/one")));
}

}  // namespace dn::testing::apps_test
