#include <dn/geo/text_fields.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "load_json.h"
#include "run_program.h"
#include "strip_scenario.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// Rewrites the rows of a text file, without the header; `change` gets the fields of a row.
void ChangeRows(const fs::path& file,
                const std::function<void(std::vector<std::string>*)>& change) {
  std::istringstream in(FileContent(file));
  std::string header, out;
  std::getline(in, header);
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> fields;
    for (const std::string_view field : SplitFields(line)) fields.emplace_back(field);
    change(&fields);
    std::string row;
    for (const std::string& field : fields) row += (row.empty() ? "" : ", ") + field;
    out += row + "\n";
  }
  std::ofstream(file) << header + "\n" + out;
}

/// A simulated flight with six points and eight checks, and its calibration.
class CliControl : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    Simulate(ShortScenario(), "flight");
    run_ = new ProgramRun(Calibrate("flight", "result"));
  }
  static void TearDownTestSuite() {
    delete run_;
    delete folder_;
  }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }
  static void Simulate(const fs::path& scenario, const std::string& out) {
    const ProgramRun run =
        RunProgram({"simulate", scenario.string(), "--seed", "5", "--out", Path(out).string(),
                    "--set", "control={points: 6, checks: 8}"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static ProgramRun Calibrate(const std::string& flight, const std::string& out,
                              const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"calibrate", Path(flight).string(), "--out",
                                       Path(out).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
  static Json Result(const std::string& out) { return LoadJson(Path(out) / "result.json"); }
  static Json Point(const Json& result, const std::string& name) {
    for (const Json& point : result["control"]["points"]) {
      if (point["name"] == name) return point;
    }
    return nullptr;
  }
  /// Copies the flight, to be changed.
  static void Copy(const std::string& to) {
    fs::copy(Path("flight"), Path(to), fs::copy_options::recursive);
  }

  inline static TempFolder* folder_ = nullptr;
  inline static ProgramRun* run_ = nullptr;
};

TEST_F(CliControl, TheResultHasResidualsInfluenceAndAccuracy) {
  ASSERT_EQ(run_->exit_code, 0) << run_->err;
  const Json result = Result("result");
  const Json& control = result["control"];
  ASSERT_EQ(control["points"].size(), 14u);
  EXPECT_EQ(Point(result, "P1")["role"], "observation");
  EXPECT_EQ(Point(result, "C8")["role"], "check");
  EXPECT_TRUE(Point(result, "C8")["boresight_influence_mdeg"].is_null());
  EXPECT_EQ(Point(result, "P1")["boresight_influence_mdeg"].size(), 3u);
  for (const char* component : {"vertical", "horizontal"}) {
    const Json& accuracy = control["accuracy"][component];
    EXPECT_EQ(accuracy["checks"], 8) << component;
    const double combined_m =
        std::hypot(accuracy["rmse_m"].get<double>(), accuracy["survey_m"].get<double>());
    EXPECT_NEAR(accuracy["combined_m"].get<double>(), combined_m, 1e-9);
    EXPECT_LT(combined_m, 0.2);
  }
  EXPECT_LT(control["checks_variance"].get<double>(), 2.5);
  EXPECT_THAT(run_->out, HasSubstr("vertical accuracy"));
  EXPECT_THAT(run_->out, HasSubstr("at least 30 checks"));
  EXPECT_THAT(FileContent(Path("result") / "report.html"), HasSubstr("Laser minus survey"));
}

TEST_F(CliControl, AWrongPointIsLeftOutAndNamedWithItsLine) {
  Copy("wrong");
  ChangeRows(Path("wrong") / "control" / "points.txt", [](std::vector<std::string>* fields) {
    if (fields->front() == "P4") (*fields)[3] = std::to_string(std::stod((*fields)[3]) + 0.5);
  });
  const ProgramRun run = Calibrate("wrong", "wrong_result");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json result = Result("wrong_result");
  EXPECT_EQ(Point(result, "P4")["role"], "rejected");
  EXPECT_EQ(Point(result, "P3")["role"], "observation");
  EXPECT_THAT(run.out, HasSubstr("control point P4 contradicts all other data"));
  EXPECT_THAT(run.out, HasSubstr("points.txt:5"));
}

TEST_F(CliControl, TheOtherMethodsSayThatTheyDoNotUseIt) {
  RunProgram({"smooth", Path("flight").string(), "--out", Path("smoothed").string()});
  const std::string trajectory = (Path("smoothed") / "trajectory.out").string();
  const ProgramRun run =
      Calibrate("flight", "given_result", {"--method", "gh", "--trajectory", trajectory});
  EXPECT_THAT(run.err, HasSubstr("the control of the flight is not used"));
  EXPECT_FALSE(Result("given_result").contains("control"));
}

TEST_F(CliControl, ABadFileIsNamedWithItsLine) {
  Copy("bad");
  ChangeRows(Path("bad") / "control" / "points.txt", [](std::vector<std::string>* fields) {
    if (fields->front() == "P2") (*fields)[7] = "1.0";
  });
  const ProgramRun run = Calibrate("bad", "bad_result");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("points.txt:3"));
  EXPECT_THAT(run.err, HasSubstr("lies outside the IMU data"));
}

TEST_F(CliControl, PointsWithoutAVectorAreFoundInTheStrips) {
  std::ofstream(Path("strips.yaml")) << With(StripScenario("kind: flat, roughness_m: 0"),
                                             "buildings_per_km2: 800", "buildings_per_km2: 0");
  Simulate(Path("strips.yaml"), "strips");
  for (const char* file : {"points.txt", "checks.txt"}) {
    ChangeRows(Path("strips") / "control" / file, [](std::vector<std::string>* fields) {
      for (std::size_t k = 7; k < 11; ++k) (*fields)[k] = "-";
    });
  }
  const ProgramRun run =
      Calibrate("strips", "strips_result", {"--set", "control={search_radius_m: 2.5}"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json result = Result("strips_result");
  const Json& control = result["control"];
  EXPECT_GE(control["points"].size(), 10u);
  EXPECT_TRUE(control["accuracy"]["horizontal"].is_null());
  EXPECT_GE(control["accuracy"]["vertical"]["checks"], 5);
  EXPECT_LT(control["accuracy"]["vertical"]["rmse_m"].get<double>(), 0.06);
  EXPECT_LT(control["checks_variance"].get<double>(), 3.0);
}

// Peaks of gables give horizontal checks without any laser vector.
TEST_F(CliControl, CornersAreFoundInTheStrips) {
  std::ofstream(Path("town.yaml"))
      << With(StripScenario("kind: built_up"), "gsd_m: 0.7\n  pulse_rate_hz: 14000",
              "gsd_m: 0.25\n  pulse_rate_hz: 100000");
  const ProgramRun simulated =
      RunProgram({"simulate", Path("town.yaml").string(), "--seed", "5", "--out",
                  Path("town").string(), "--set", "control={corners: 3, corner_checks: 5}"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  EXPECT_THAT(FileContent(Path("town") / "control" / "checks.txt"), HasSubstr("-, corner"));
  const ProgramRun run = Calibrate("town", "town_result");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json control = Result("town_result")["control"];
  EXPECT_GE(control["points"].size(), 6u);
  const Json& horizontal = control["accuracy"]["horizontal"];
  ASSERT_FALSE(horizontal.is_null());
  EXPECT_GE(horizontal["checks"], 3);
  EXPECT_LT(horizontal["rmse_m"].get<double>(), 0.1);
  EXPECT_LT(control["checks_variance"].get<double>(), 3.0);
  const ProgramRun small =
      Calibrate("town", "small_result", {"--set", "control={corner_radius_m: 0.3}"});
  EXPECT_THAT(small.err, HasSubstr("8 of 8 control points have no laser return"));
  EXPECT_THAT(small.err, HasSubstr("a corner needs a cloud with three planes through it"));
}

}  // namespace dn::testing::apps_test
