#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "calibrated_flight.h"
#include "load_json.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A simulated flight of a scanner with four beams, and its calibration.
class CliBeams : public CalibratedFlight {
 protected:
  static void SetUpTestSuite() {
    Make({"lidar.pattern=rotating", kBeams, "pairs={count: 400, sigma_p_m: 0.03}"});
  }

  static constexpr const char* kBeams =
      "lidar.beams={angles_deg: [-12, -4, 4, 12], angle_error_deg: [0.1, -0.05, 0.05, -0.1], "
      "range_error_m: [0.02, -0.02, -0.03, 0.03]}";
};

/// Expects the corrections that the flight was simulated with, within four sigmas.
void ExpectTrueCorrections(const Json& beams) {
  const double truth_deg[] = {0.1, -0.05, 0.05, -0.1}, truth_m[] = {0.02, -0.02, -0.03, 0.03};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto expect_near = [&](const char* key, double truth) {
      const Json& corrections = beams[key];
      ASSERT_TRUE(corrections["observable"][k].get<bool>()) << key << k;
      EXPECT_NEAR(corrections["value"][k].get<double>(), truth,
                  4.0 * corrections["sigma"][k].get<double>())
          << key << k;
    };
    expect_near("angle", truth_deg[k]);
    expect_near("range_offset", truth_m[k]);
  }
}

TEST_F(CliBeams, TheResultHasTheCorrectionsOfTheBeams) {
  ASSERT_EQ(run_->exit_code, 0) << run_->err;
  const Json beams = LoadJson(fs::path(Path("result")) / "result.json")["beams"];
  ASSERT_EQ(beams.size(), 1u);
  ExpectTrueCorrections(beams[0]);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_GT(beams[0]["ends"][k].get<long>(), 100);
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

TEST_F(CliBeams, CheckSaysWhatCalibrateDoesWithThem) {
  const ProgramRun run = RunProgram({"check", Path("flight"), "--out", Path("check")});
  EXPECT_THAT(run.out, HasSubstr("4 of 4 beams measured pairs"));
  EXPECT_THAT(run.out, HasSubstr("calibrate estimates their corrections"));
  const Json checked = LoadJson(fs::path(Path("check")) / "report.json")["pairs"]["beams"];
  const Json result = LoadJson(fs::path(Path("result")) / "result.json")["beams"];
  EXPECT_EQ(checked[0]["ends"], result[0]["ends"]);
  EXPECT_EQ(checked[0]["stated"], 4);
  const ProgramRun unstated =
      RunProgram({"check", Path("flight"), "--set", "lidar.beams=~", "--out", Path("unstated")});
  EXPECT_THAT(unstated.out, HasSubstr("calibrate takes them for one beam: state lidar.beams"));
}

TEST_F(CliBeams, InitStatesThem) {
  const fs::path folder = Path("files");
  fs::copy(Path("flight"), folder, fs::copy_options::recursive);
  for (const char* made : {"flight.yaml", "truth.yaml", "reference.out"}) {
    fs::remove(folder / made);
  }
  const ProgramRun run = RunProgram({"init", folder.string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(FileContent(folder / "flight.yaml"),
              HasSubstr("beams: {count: 4, angle_sigma_deg: 0.1, range_offset_sigma_m: 0.03}"));
  EXPECT_THAT(run.out, HasSubstr("the angles of the beams"));
  const ProgramRun check = RunProgram({"check", folder.string(), "--out", Path("check_files")});
  EXPECT_THAT(check.out, HasSubstr("4 of 4 beams measured pairs"));
}

/// Returns the numbers of the first row of a text file that is not a comment.
std::vector<double> FirstRow(const std::string& file) {
  std::istringstream lines(FileContent(file));
  std::string line;
  while (std::getline(lines, line) && line.starts_with('#')) {
  }
  std::vector<double> row;
  std::istringstream cells(line);
  for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
  return row;
}

// The first end of a pair as a point: with the result it moves by the errors of its beam.
TEST_F(CliBeams, GeoreferencingTakesTheirErrorsOut) {
  const std::vector<double> pair = FirstRow(Path("flight") + "/lidar/1_2.txt");
  ASSERT_EQ(pair.size(), 10u);
  fs::create_directories(Path("flight") + "/strips");
  const std::string strip = Path("flight") + "/strips/1.txt";
  const auto write = [&](const std::string& beam) {
    std::ofstream out(strip);
    out.precision(17);
    out << pair[0] << ", 0, 0, 0, " << pair[2] << ", " << pair[3] << ", " << pair[4] << beam;
  };
  const auto georeference = [&](const std::string& name, const std::vector<std::string>& source) {
    std::vector<std::string> words{"georef", Path("flight"), "--out", Path(name)};
    words.insert(words.end(), source.begin(), source.end());
    const ProgramRun run = RunProgram(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const std::vector<double> row = FirstRow(Path(name) + "/strips/1.txt");
    return Eigen::Vector3d(row.at(1), row.at(2), row.at(3));
  };
  const Json result = LoadJson(fs::path(Path("result")) / "result.json");
  std::string angles;
  for (const Json& angle : result["boresight"]["angles_deg"]) {
    angles += (angles.empty() ? "" : ",") + angle.dump();
  }
  write(", " + std::to_string(static_cast<int>(pair[8])) + "\n");
  const Eigen::Vector3d with = georeference("with", {"--result", Path("result") + "/result.json"});
  const Eigen::Vector3d without = georeference(
      "plain", {"--boresight=" + angles, "--trajectory", Path("result") + "/trajectory.out"});
  const Eigen::Vector3d both =
      georeference("both", {"--result", Path("result") + "/result.json", "--boresight=" + angles});
  EXPECT_LT((both - with).norm(), 1e-6);
  const auto k = static_cast<std::size_t>(pair[8]);
  const Json& beams = result["beams"][0];
  const double range_m = std::sqrt(pair[2] * pair[2] + pair[3] * pair[3] + pair[4] * pair[4]);
  const double turned_m =
      beams["angle"]["value"][k].get<double>() * std::numbers::pi / 180.0 * range_m;
  EXPECT_NEAR((with - without).norm(),
              std::hypot(turned_m, beams["range_offset"]["value"][k].get<double>()), 1e-3);
  write("\n");
  const ProgramRun refused = RunProgram({"georef", Path("flight"), "--out", Path("no_beam"),
                                         "--result", Path("result") + "/result.json"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("no laser vectors with beams"));
  const ProgramRun early =
      RunProgram({"calibrate", Path("flight"), "--georef", "--out", Path("early")});
  EXPECT_EQ(early.exit_code, 1);
  EXPECT_THAT(early.err, HasSubstr("calibrate without --georef"));
  EXPECT_THAT(early.err, ::testing::Not(HasSubstr("final least squares")));
  fs::remove_all(Path("flight") + "/strips");
}

// The Gauss-Helmert adjustment finds the same corrections on the smoothed trajectory.
TEST_F(CliBeams, TheGaussHelmertAdjustmentEstimatesThem) {
  ASSERT_EQ(RunProgram({"smooth", Path("flight"), "--out", Path("smoothed")}).exit_code, 0);
  const ProgramRun run = RunProgram({"calibrate", Path("flight"), "--method", "gh", "--trajectory",
                                     Path("smoothed") + "/trajectory.out", "--out", Path("gh")});
  EXPECT_THAT(run.out, HasSubstr("beam angles [deg], correction relative to their mean"));
  const Json beams = LoadJson(fs::path(Path("gh")) / "result.json")["beams"];
  ExpectTrueCorrections(beams[0]);
  EXPECT_EQ(beams[0]["ends"],
            LoadJson(fs::path(Path("result")) / "result.json")["beams"][0]["ends"]);
}

TEST_F(CliBeams, WithoutTheKeyTheyAreNotUnknowns) {
  const ProgramRun run =
      RunProgram({"calibrate", Path("flight"), "--set", "lidar.beams=~", "--out", Path("without")});
  const Json result = LoadJson(fs::path(Path("without")) / "result.json");
  EXPECT_FALSE(result.contains("beams"));
}

}  // namespace dn::testing::apps_test
