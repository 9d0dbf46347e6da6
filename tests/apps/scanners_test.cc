#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "calibrated_flight.h"
#include "load_json.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kScannerList =
    "lidar=[{name: a, R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]], scan_axis: [0, 1, 0], "
    "nadir_axis: [1, 0, 0], boresight_deg: [0.2, 0.03, 0.35], fov_deg: 75, gsd_m: 0.2}, {name: b, "
    "R_sensor_to_body: [[0.5, 0.8660254037844386, 0], [0, 0, 1], [0.8660254037844386, -0.5, 0]], "
    "scan_axis: [0, 1, 0], nadir_axis: [1, 0, 0], lever_arm_m: [0.3, 0, 0.1], boresight_deg: "
    "[-0.4, 0.5, 0.1], fov_deg: 75, gsd_m: 0.2}]";

/// A simulated flight of two scanners, and its calibration.
class CliScanners : public CalibratedFlight {
 protected:
  static void SetUpTestSuite() { Make({kScannerList, "pairs={count: 200, between: 150}"}); }
};

TEST_F(CliScanners, TheResultHasEachAndTheRelativeBoresight) {
  ASSERT_EQ(run_->exit_code, 0) << run_->err;
  const Json result = LoadJson(fs::path(Path("result")) / "result.json");
  ASSERT_EQ(result["scanners"].size(), 2u);
  EXPECT_EQ(result["scanners"][1]["name"], "b");
  EXPECT_EQ(result["scanners"][0]["boresight"]["angles_deg"], result["boresight"]["angles_deg"]);
  const double truth_deg[] = {-0.4, 0.5, 0.1};
  const Json &a = result["boresight"], &b = result["scanners"][1]["boresight"];
  double relative_deg2 = 0.0, separate_deg2 = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma_deg = b["sigma_deg"][i].get<double>();
    EXPECT_NEAR(b["angles_deg"][i].get<double>(), truth_deg[i], 4.0 * sigma_deg);
    relative_deg2 += std::pow(result["relative_boresight"][0]["sigma_deg"][i].get<double>(), 2);
    separate_deg2 += std::pow(a["sigma_deg"][i].get<double>(), 2) + std::pow(sigma_deg, 2);
  }
  EXPECT_LT(relative_deg2, 0.9 * separate_deg2);  // the errors that both have in common cancel
  EXPECT_THAT(run_->out, HasSubstr("a to b"));
  EXPECT_THAT(FileContent(fs::path(Path("result")) / "report.html"),
              HasSubstr("Relative boresight of every two scanners"));
}

TEST_F(CliScanners, AResolvedConfigurationGivesTheSameResult) {
  const std::string resolved = Path("result") + "/config.resolved.yaml";
  EXPECT_THAT(FileContent(resolved), HasSubstr("pairs_between:"));
  const ProgramRun check = RunProgram({"check", Path("flight")});
  EXPECT_EQ(check.exit_code, 0) << check.err;
}

TEST_F(CliScanners, OneScannerCanBeSelected) {
  const ProgramRun run =
      RunProgram({"calibrate", Path("flight"), "--scanner", "b", "--out", Path("only_b")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json result = LoadJson(fs::path(Path("only_b")) / "result.json");
  EXPECT_FALSE(result.contains("scanners"));
  EXPECT_NEAR(result["boresight"]["angles_deg"][1].get<double>(), 0.5, 0.05);
  EXPECT_THAT(run.out, HasSubstr("0.500000"));  // the truth of this scanner
}

TEST_F(CliScanners, TheOneWithTooFewPairsIsNamed) {
  fs::copy(Path("flight"), Path("few"), fs::copy_options::recursive);
  for (const auto& file : fs::directory_iterator(Path("few") + "/lidar_b")) {
    std::istringstream rows(FileContent(file.path()));
    std::string kept, row;
    while (std::getline(rows, row) && row.starts_with('#')) kept += row + '\n';
    std::ofstream(file.path()) << kept + row + '\n';
  }
  const ProgramRun run = RunProgram(
      {"calibrate", Path("few"), "--set", "pairs_between=[]", "--out", Path("few_result")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("the boresight of scanner b is not observable: only "));
}

TEST_F(CliScanners, StripsGetTheBoresightOfTheirScanner) {
  const std::vector<std::string> georef = {"georef",       Path("flight"),
                                           "--scanner",    "b",
                                           "--trajectory", Path("flight") + "/reference.out"};
  fs::create_directory(Path("flight") + "/strips_b");
  std::ofstream(Path("flight") + "/strips_b/1.txt")
      << "# t, x, y, z, ux, uy, uz\n381100, 0, 0, 0, 100, 0, 0\n";
  const auto run = [&](const std::string& result, const std::string& out) {
    std::vector<std::string> words = georef;
    words.insert(words.end(), {"--result", Path(result) + "/result.json", "--out", Path(out)});
    return RunProgram(words);
  };
  const ProgramRun both = run("result", "georef_b");
  ASSERT_EQ(both.exit_code, 0) << both.err;
  const Json result = LoadJson(fs::path(Path("result")) / "result.json");
  const Json stored = LoadJson(fs::path(Path("georef_b")) / "georef.json");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(stored["boresight_deg"][i].get<double>(),
                result["scanners"][1]["boresight"]["angles_deg"][i].get<double>(), 1e-9);
  }
  const ProgramRun only_a =
      RunProgram({"calibrate", Path("flight"), "--scanner", "a", "--out", Path("only_a")});
  ASSERT_EQ(only_a.exit_code, 0) << only_a.err;
  EXPECT_EQ(LoadJson(fs::path(Path("only_a")) / "result.json")["scanner"], "a");
  const ProgramRun wrong = run("only_a", "georef_wrong");
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("this result is of scanner a, but the strips are of b"));
  EXPECT_FALSE(fs::exists(Path("georef_wrong") + "/georef.json"));
}

TEST_F(CliScanners, CommandsForOneSaySo) {
  const std::vector<std::vector<std::string>> commands = {
      {"gap", Path("flight"), "--out", Path("gap")},
      {"calibrate", Path("flight"), "--method", "gh", "--out", Path("gh")}};
  for (const std::vector<std::string>& command : commands) {
    const ProgramRun run = RunProgram(command);
    EXPECT_EQ(run.exit_code, 2) << command.front();
    EXPECT_THAT(run.err, HasSubstr("has 2 scanners (a, b)")) << command.front();
    EXPECT_THAT(run.err, HasSubstr("add --scanner a")) << command.front();
  }
}

TEST_F(CliScanners, AStudyHasTheSigmasOfEach) {
  const ProgramRun run = RunProgram({"study", Path("flight"), "--out", Path("study")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json study = LoadJson(fs::path(Path("study")) / "study.json");
  ASSERT_EQ(study["scanners"].size(), 2u);
  EXPECT_EQ(study["relative_boresight"][0]["sigma_deg"].size(), 3u);
  EXPECT_FALSE(study["relative_boresight"][0].contains("angles_deg"));
  EXPECT_THAT(run.out, HasSubstr("boresight a to b, sigma"));
}

}  // namespace dn::testing::apps_test
