#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "load_json.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A simulated flight of a scanner with four beams, and its calibration.
class CliBeams : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    const ProgramRun simulated =
        RunProgram({"simulate", ShortScenario().string(), "--seed", "5", "--out", Path("flight"),
                    "--set", "lidar.pattern=rotating", "--set", kBeams, "--set",
                    "pairs={count: 400, sigma_p_m: 0.03}"});
    ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
    run_ = new ProgramRun(RunProgram({"calibrate", Path("flight"), "--out", Path("result")}));
  }
  static void TearDownTestSuite() {
    delete run_;
    delete folder_;
  }
  static std::string Path(const std::string& name) { return (folder_->path() / name).string(); }

  static constexpr const char* kBeams =
      "lidar.beams={angles_deg: [-12, -4, 4, 12], angle_error_deg: [0.1, -0.05, 0.05, -0.1], "
      "range_error_m: [0.02, -0.02, -0.03, 0.03]}";
  inline static TempFolder* folder_ = nullptr;
  inline static ProgramRun* run_ = nullptr;
};

TEST_F(CliBeams, TheResultHasTheCorrectionsOfTheBeams) {
  ASSERT_EQ(run_->exit_code, 0) << run_->err;
  const Json beams = LoadJson(fs::path(Path("result")) / "result.json")["beams"];
  ASSERT_EQ(beams.size(), 1u);
  const double truth_deg[] = {0.1, -0.05, 0.05, -0.1}, truth_m[] = {0.02, -0.02, -0.03, 0.03};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto expect_near = [&](const char* key, double truth) {
      const Json& corrections = beams[0][key];
      ASSERT_TRUE(corrections["observable"][k].get<bool>()) << key << k;
      EXPECT_NEAR(corrections["value"][k].get<double>(), truth,
                  4.0 * corrections["sigma"][k].get<double>())
          << key << k;
    };
    expect_near("angle", truth_deg[k]);
    expect_near("range_offset", truth_m[k]);
    EXPECT_GT(beams[0]["ends"][k].get<long>(), 100);
  }
  EXPECT_THAT(run_->out, HasSubstr("beam angles [deg], correction relative to their mean"));
  const std::string page = FileContent(fs::path(Path("result")) / "report.html");
  EXPECT_THAT(page, HasSubstr("How do the beams differ?"));
  EXPECT_THAT(FileContent(Path("flight") + "/truth.yaml"), HasSubstr("angle_error_deg: [0.1"));
}

TEST_F(CliBeams, AStudyHasTheirSigmas) {
  const ProgramRun run = RunProgram({"study", Path("flight"), "--out", Path("study")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json study = LoadJson(fs::path(Path("study")) / "study.json");
  const Json result = LoadJson(fs::path(Path("result")) / "result.json");
  for (std::size_t k = 0; k < 4; ++k) {
    const double sigma_deg = study["beams"][0]["angle"]["sigma"][k].get<double>();
    EXPECT_NEAR(sigma_deg, result["beams"][0]["angle"]["sigma"][k].get<double>(), 0.05 * sigma_deg);
  }
  EXPECT_FALSE(study["beams"][0]["angle"].contains("value"));
  EXPECT_THAT(run.out, HasSubstr("beam range offsets [m], sigma relative to their mean"));
}

TEST_F(CliBeams, WithoutTheKeyTheyAreNotUnknowns) {
  const ProgramRun run =
      RunProgram({"calibrate", Path("flight"), "--set", "lidar.beams=~", "--out", Path("without")});
  const Json result = LoadJson(fs::path(Path("without")) / "result.json");
  EXPECT_FALSE(result.contains("beams"));
}

}  // namespace dn::testing::apps_test
