#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "page_numbers.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
namespace fs = std::filesystem;

Json JsonIn(const fs::path& file) { return Json::parse(FileContent(file)); }

TEST(CliStudy, OfAScenarioWritesWhatTheContractNames) {
  const TempFolder folder;
  const fs::path out = folder.path() / "study";
  const ProgramRun run = RunProgram({"study", ShortScenario(), "--no-remedies", "--out", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(NamesIn(out),
              IsSupersetOf({"config.resolved.yaml", "report.json", "study.json", "summary.txt"}));
  EXPECT_EQ(run.out, FileContent(out / "summary.txt"));
  ExpectPageMatchesFiles(out, 20);
  const Json study = JsonIn(out / "study.json");
  EXPECT_EQ(study["schema"], "dn.study/1");
  for (const char* key : {"sigma_deg", "covariance_deg2", "correlation"}) {
    EXPECT_EQ(study["boresight"][key].size(), 3u) << key;
  }
  EXPECT_GT(study["condition_number"], 1.0);
  for (const char* key : {"boresight_to_accel_bias", "boresight_to_gyro_bias"}) {
    EXPECT_EQ(study["correlations"][key]["at_barycentre"].size(), 3u) << key;
    EXPECT_GE(study["correlations"][key]["max_abs"], study["correlations"][key]["rms"]) << key;
  }
  for (const char* key : {"rp_deg", "yaw_deg", "position_m"}) {
    EXPECT_GT(study["trajectory_sigma"][key], 0.0) << key;
  }
  ASSERT_FALSE(study["weak_directions"].empty());
  for (const char* key :
       {"unknowns", "correlation", "sigma", "cause", "remedy", "sigma_after_remedy"}) {
    EXPECT_TRUE(study["weak_directions"][0].contains(key)) << key;
  }
}

TEST(CliStudyManyRuns, OfAFlightAgreesWithItsCalibration) {
  const TempFolder folder;
  const fs::path out = folder.path() / "study";
  const ProgramRun run = RunProgram({"study", ShortFlight(), "--out", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json study = JsonIn(out / "study.json");
  const Json calibrated = JsonIn(CalibrateResult() / "result.json");
  for (std::size_t i = 0; i < 3; ++i) {
    const double ratio = study["boresight"]["sigma_deg"][i].get<double>() /
                         calibrated["boresight"]["sigma_deg"][i].get<double>();
    EXPECT_NEAR(ratio, 1.0, 0.02) << i;
  }
  EXPECT_TRUE(study["weak_directions"][0]["sigma_after_remedy"].is_null());
}

TEST(CliStudyManyRuns, SizesOfEffectsAreThoseOfTheDiagnosis) {
  const TempFolder folder;
  const fs::path out = folder.path() / "study", limits = folder.path() / "limits";
  // The turbulence of the flight was simulated with this seed.
  const ProgramRun run =
      RunProgram({"study", ShortScenario(), "--seed", "3", "--no-remedies", "--out", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("undetectable effects"));
  ASSERT_EQ(RunProgram({"gap", ShortFlight(), "--limits", "--out", limits}).exit_code, 0);
  std::map<std::string, Json> planned;
  const Json study = JsonIn(out / "study.json");
  for (const Json& effect : study["could_still_hide"]) {
    planned[effect["effect"]] = effect;
  }
  const Json flown = JsonIn(limits / "gap.json")["could_still_hide"];
  ASSERT_GT(flown.size(), 15u);
  EXPECT_EQ(planned.size(), flown.size());
  for (const Json& effect : flown) {
    const std::string name = effect["effect"];
    ASSERT_TRUE(planned.contains(name)) << name;
    EXPECT_EQ(planned[name]["unit"], effect["unit"]) << name;
    if (effect["minimal_detectable"].is_null()) continue;
    const double size = effect["minimal_detectable"];
    EXPECT_NEAR(planned[name]["minimal_detectable"].get<double>(), size, 0.05 * size) << name;
  }
}

TEST(CliStudy, SizesOfEffectsCanBeLeftOut) {
  const TempFolder folder;
  const fs::path out = folder.path() / "study";
  const ProgramRun run =
      RunProgram({"study", ShortScenario(), "--no-remedies", "--no-limits", "--out", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(JsonIn(out / "study.json").contains("could_still_hide"));
}

TEST(CliStudy, AValueOfTheScenarioCanBeReplaced) {
  const TempFolder folder;
  const fs::path out = folder.path() / "study";
  const ProgramRun run = RunProgram({"study", ShortScenario(), "--set", "name=replaced",
                                     "--no-remedies", "--no-limits", "--out", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(JsonIn(out / "report.json")["flight"], "replaced");
}

/// The short scenario without one of its lines, and a sweep over its lines.
struct OneStrip {
  TempFolder folder;
  fs::path scenario = folder.path() / "one.yaml";

  OneStrip() { folder.Write("one.yaml", WithoutLines(FileContent(ShortScenario()), "[0, -400,")); }
};

TEST(CliStudy, OneStripFails) {
  const OneStrip one;
  const fs::path out = one.folder.path() / "study";
  const ProgramRun run = RunProgram({"study", one.scenario, "--out", out});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("the boresight is not observable"));
  EXPECT_FALSE(fs::exists(out / "study.json"));
  EXPECT_EQ(JsonIn(out / "report.json")["error"]["kind"], "not_observable");
}

TEST(CliStudy, WrongUsageIsSaid) {
  const TempFolder folder;
  const std::string out = (folder.path() / "study").string();
  EXPECT_EQ(RunProgram({"study", "--out", out}).exit_code, 2);
  EXPECT_EQ(RunProgram({"study", "lar33", "--out", out}).exit_code, 2);
  EXPECT_EQ(RunProgram({"study", "lar3", "--shard", "1/2", "--out", out}).exit_code, 2);
  EXPECT_EQ(RunProgram({"study", "lar3", "--sweep", "x.yaml", "--out", out}).exit_code, 2);
  const ProgramRun wrong =
      RunProgram({"study", ShortScenario(), "--estimate", "gnss_levr_arm", "--out", out});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("gnss_lever_arm"));
}

ProgramRun SweepShard(const fs::path& file, const std::string& shard, const fs::path& out) {
  return RunProgram({"study", "--sweep", file, "--shard", shard, "--threads", "1", "--out", out});
}

TEST(CliStudyManyRuns, MergedShardsOfASweepAreTheBytesOfOneRun) {
  const TempFolder folder;
  folder.Write("short.yaml", FileContent(ShortScenario()));
  folder.Write("sweep.yaml",
               "base: short.yaml\n"
               "sweep:\n"
               "  plan.lines:\n"
               "    one: [[-400, 0, 400, 0, 200, 45]]\n"
               "    cross: [[-400, 0, 400, 0, 200, 45], [0, -400, 0, 400, 240, 45]]\n"
               "  pairs.count: [200, 400]\n");
  const fs::path file = folder.path() / "sweep.yaml";
  const fs::path one = folder.path() / "one", two = folder.path() / "two";
  const fs::path both = folder.path() / "both", whole = folder.path() / "whole";
  const ProgramRun first = SweepShard(file, "1/2", one);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("design 1: the boresight is not observable"));
  ASSERT_EQ(SweepShard(file, "2/2", two).exit_code, 0);
  const ProgramRun merge = RunProgram({"merge", two, one, "--out", both});
  ASSERT_EQ(merge.exit_code, 0) << merge.err;
  const ProgramRun run = SweepShard(file, "1/1", whole);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(merge.out, run.out);
  EXPECT_EQ(NamesIn(both), NamesIn(whole));
  for (const char* name : {"sweep.csv", "sweep.json", "summary.txt", "config.resolved.yaml",
                           "base.yaml", "report.html"}) {
    EXPECT_EQ(FileContent(both / name), FileContent(whole / name)) << name;
  }
  ExpectPageMatchesFiles(whole, 12);
  EXPECT_THAT(FileContent(whole / "report.html"), HasSubstr("2 of them would determine"));
  const std::string csv = FileContent(whole / "sweep.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
  EXPECT_EQ(RunProgram({"merge", one, "--out", folder.path() / "part"}).exit_code, 2);
}

TEST(CliStudyManyRuns, ChoosesTheLinesOfThePlan) {
  const TempFolder folder;
  folder.Write("short.yaml", FileContent(ShortScenario()));
  const std::string lines =
      "lines:\n"
      "  east: [-400, 0, 400, 0, 200, 45]\n"
      "  west: [400, 60, -400, 60, 200, 45]\n"
      "  across: [0, -400, 0, 400, 240, 45]\n";
  folder.Write("near.yaml", "base: short.yaml\ntarget_deg: [0.5, 0.5, 0.5]\n" + lines);
  folder.Write("far.yaml", "base: short.yaml\ntarget_deg: [1e-6, 0.5, 0.5]\n" + lines);
  const fs::path out = folder.path() / "plan";
  const ProgramRun run =
      RunProgram({"study", "--optimise", folder.path() / "near.yaml", "--out", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json result = JsonIn(out / "optimise.json");
  EXPECT_EQ(result["schema"], "dn.optimise/1");
  EXPECT_EQ(result["best"]["lines"].size(), 2u);
  EXPECT_EQ(RunProgram({"study", out / "plan.yaml", "--out", folder.path() / "study"}).exit_code,
            0);
  const ProgramRun missed =
      RunProgram({"study", "--optimise", folder.path() / "far.yaml", "--out", out});
  EXPECT_EQ(missed.exit_code, 1);
  EXPECT_THAT(missed.err, HasSubstr("roll"));
  EXPECT_TRUE(fs::exists(out / "designs.csv"));
  EXPECT_FALSE(fs::exists(out / "plan.yaml"));
}

}  // namespace dn::testing::apps_test
