#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/report/json.h>
#include <dn/rotation.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "damaged_flight.h"
#include "load_json.h"

namespace dn::testing::apps_test {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
namespace fs = std::filesystem;

std::string SmoothedTrajectory() { return (SmoothResult() / "trajectory.out").string(); }

/// Removes the section imu from flight.yaml.
void RemoveImuSection(const DamagedFlight& flight) {
  std::string yaml = flight.Read("flight.yaml");
  const std::size_t begin = yaml.find("\nimu:") + 1;
  ASSERT_NE(begin, 0u);
  std::size_t end = yaml.find('\n', begin) + 1;
  while (end < yaml.size() && yaml[end] == ' ') end = yaml.find('\n', end) + 1;
  flight.Write("flight.yaml", yaml.erase(begin, end - begin));
  fs::remove(flight.path() / "IMU.txt");
}

void ExpectNear(const Json& boresight, double sigmas) {
  const double truth_deg[] = {0.2, 0.03, 0.35};
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma = boresight["sigma_deg"][i];
    EXPECT_NEAR(boresight["angles_deg"][i].get<double>(), truth_deg[i], sigmas * sigma);
    EXPECT_NEAR(sigma, std::sqrt(boresight["covariance_deg2"][i][i].get<double>()), 1e-12 * sigma);
    EXPECT_GT(sigma, boresight["sigma_scaled_deg"][i].get<double>());
    EXPECT_GT(boresight["sigma_apriori_deg"][i].get<double>(), 0.0);
  }
}

/// Formats a trajectory as text in grid coordinates, with angles relative to grid north.
std::string InUtm(const Trajectory& trajectory, const std::string& crs) {
  const LocalFrame frame(trajectory.points().front().position);
  const PointCrs grid(crs, frame);
  std::string text;
  for (const NavPoint& point : trajectory.points()) {
    const Eigen::Vector3d p_m = frame.ToMap(point.position);
    const Eigen::Vector3d p_c = grid.FromMap(p_m);
    const Eigen::Vector3d north_c = grid.J_c_m(p_m) * frame.R_mn(p_m).col(0);
    Eigen::Vector3d rph_rad = RollPitchHeading(point.q_nb);
    rph_rad.z() += std::atan2(north_c.x(), north_c.y());
    text += FormatDouble(point.t_s);
    for (const double x : p_c) text += ' ' + FormatDouble(x);
    for (const double angle : rph_rad) text += ' ' + FormatDouble(kDegPerRad * angle);
    text += '\n';
  }
  return text;
}

TEST(CliGaussHelmert, TakesATrajectoryInTheConventionsOfOthers) {
  const DamagedFlight flight;
  const ProgramRun sbet =
      flight.Run("calibrate", {"--method", "gh", "--trajectory", SmoothedTrajectory()});
  ASSERT_EQ(sbet.exit_code, 0) << sbet.err;
  const Json expected = LoadJson(flight.out() / "result.json")["boresight"]["angles_deg"];

  flight.Write("grid.txt", InUtm(ReadTrajectory(SmoothedTrajectory()), "utm:32n"));
  fs::copy_file(SmoothResult() / "trajectory_covariance.txt",
                flight.path() / "trajectory_covariance.txt");
  const ProgramRun run = flight.Run(
      "calibrate",
      {"--method", "gh", "--set", "trajectory.file=grid.txt", "--set", "trajectory.crs=utm:32n",
       "--set", "trajectory.attitude=roll_pitch_heading_deg", "--set", "trajectory.north=grid"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json angles_deg = LoadJson(flight.out() / "result.json")["boresight"]["angles_deg"];
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(angles_deg[i].get<double>(), expected[i].get<double>(), 1e-6);
  }
}

TEST(CliGaussHelmert, ResultOnTheSmoothedTrajectory) {
  const DamagedFlight flight;
  const ProgramRun run =
      flight.Run("calibrate", {"--method", "gh", "--trajectory", SmoothedTrajectory()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(NamesIn(flight.out()), ElementsAre("config.resolved.yaml", "pair_residuals.txt",
                                                 "pairs.geojson", "report.html", "report.json",
                                                 "result.json", "swaths.geojson", "swaths.json"));
  const Json result = LoadJson(flight.out() / "result.json");
  EXPECT_EQ(result["schema"], "dn.result/1");
  EXPECT_EQ(result["method"], "gh");
  ExpectNear(result["boresight"], 4.5);
  EXPECT_TRUE(result["correlations"].is_null());
  EXPECT_TRUE(result["estimates"].is_null());
  const Json& adjustment = result["adjustment"];
  for (const char* key : {"nodes", "imu_epochs", "gnss_epochs"}) {
    EXPECT_TRUE(adjustment.at(key).is_null()) << key;
  }
  for (const char* key :
       {"sigma0", "chi2", "redundancy", "condition_number", "iterations", "residual_initial_m",
        "residual_final_m", "parameters", "correspondences", "outliers"}) {
    EXPECT_TRUE(adjustment.at(key).is_number()) << key;
  }
  EXPECT_TRUE(adjustment["converged"].get<bool>());
  EXPECT_LT(adjustment["residual_final_m"], adjustment["residual_initial_m"]);
  EXPECT_THAT(result["assessment"]["verdict"].get<std::string>(), AnyOf("calibrated", "absorbed"));
  EXPECT_FALSE(result["assessment"]["reasons"].empty());
  EXPECT_THAT(run.out, HasSubstr("by the Gauss-Helmert adjustment"));
  EXPECT_THAT(run.out, HasSubstr("times those of the normal matrix"));
  const Json report = LoadJson(flight.out() / "report.json");
  EXPECT_EQ(report["gauss_helmert"]["trajectory_sigma"]["source"], "trajectory_covariance.txt");
  EXPECT_GT(report["gauss_helmert"]["within_flight_scatter"]["nodes"], 1);
  EXPECT_NEAR(report["gauss_helmert"]["within_flight_scatter"]["attitude_ratio"], 1.0, 0.5);
}

TEST(CliGaussHelmert, AllMethodsAndTheirComparison) {
  const DamagedFlight flight;
  const ProgramRun run =
      flight.Run("calibrate", {"--method", "all", "--trajectory", SmoothedTrajectory()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(NamesIn(flight.out()),
              IsSupersetOf({"comparison.json", "report.json", "result_dn.json", "result_gh.json",
                            "trajectory.out", "trajectory_sigma.txt"}));
  EXPECT_EQ(FileContent(flight.out() / "result.json"),
            FileContent(flight.out() / "result_dn.json"));
  const Json dn = LoadJson(flight.out() / "result_dn.json");
  const Json gh = LoadJson(flight.out() / "result_gh.json");
  EXPECT_EQ(dn["method"], "dn");
  EXPECT_EQ(gh["method"], "gh");
  EXPECT_EQ(dn["boresight"],
            LoadJson(CalibrateResult() / "result.json")["boresight"]);  // same as --method dn alone
  const Json comparison = LoadJson(flight.out() / "comparison.json");
  EXPECT_EQ(comparison["methods"]["dn"]["angles_deg"], dn["boresight"]["angles_deg"]);
  EXPECT_EQ(comparison["methods"]["gh"]["sigma_deg"], gh["boresight"]["sigma_deg"]);
  EXPECT_TRUE(comparison["methods"].at("planes").is_null());
  EXPECT_THAT(comparison["notes"].dump(),
              AnyOf(HasSubstr("planes: the flight has no strips"), HasSubstr("built without PCL")));
  ASSERT_EQ(comparison["differences"].size(), 1u);
  const Json& difference = comparison["differences"][0];
  EXPECT_EQ(difference["methods"], Json({"gh", "dn"}));
  for (std::size_t i = 0; i < 3; ++i) {
    const double d = difference["difference_deg"][i];
    const double expected = gh["boresight"]["angles_deg"][i].get<double>() -
                            dn["boresight"]["angles_deg"][i].get<double>();
    // The difference is a rotation, which differs a little from the subtraction of the angles.
    EXPECT_NEAR(d, expected, 1e-4 + 0.01 * std::abs(expected));
    EXPECT_NEAR(difference["significance"][i].get<double>(),
                std::abs(d) / difference["sigma_deg"][i].get<double>(), 1e-9);
  }
  EXPECT_THAT(run.out, HasSubstr("gh - dn [deg]"));
  EXPECT_THAT(gh["assessment"]["reasons"].dump(), HasSubstr("from the dynamic network"));
}

TEST(CliPlanes, NeedStrips) {
  const DamagedFlight flight;
  const ProgramRun run =
      flight.Run("calibrate", {"--method", "planes", "--trajectory", SmoothedTrajectory()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, AnyOf(HasSubstr("the flight has no strips, and --method planes needs point"),
                             HasSubstr("built without PCL")));
}

TEST(CliGaussHelmert, IsTheDefaultWithoutInertialData) {
  const DamagedFlight flight;
  RemoveImuSection(flight);
  fs::copy_file(SmoothedTrajectory(), flight.path() / "trajectory.out");
  const ProgramRun run = flight.Run("calibrate");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json result = LoadJson(flight.out() / "result.json");
  EXPECT_EQ(result["method"], "gh");
  // Without a trajectory_sigma.txt next to the trajectory, the sigmas of flight.yaml are used.
  EXPECT_THAT(LoadJson(flight.out() / "report.json")["gauss_helmert"]["trajectory_sigma"]["source"]
                  .get<std::string>(),
              HasSubstr("flight.yaml"));
}

TEST(CliGaussHelmert, RotationModelsAndRobustLosses) {
  for (const char* section : {"gh: {rotation: small_angle}", "gh: {libor_compat: true}"}) {
    const DamagedFlight flight;
    std::string yaml = flight.Read("flight.yaml");
    const std::size_t at = yaml.find("\ngh:");
    if (at != std::string::npos) {
      std::size_t end = yaml.find('\n', at + 1) + 1;
      while (end < yaml.size() && yaml[end] == ' ') end = yaml.find('\n', end) + 1;
      yaml.erase(at + 1, end - at - 1);
    }
    flight.Write("flight.yaml", yaml + section + "\n");
    const ProgramRun run =
        flight.Run("calibrate", {"--method", "gh", "--trajectory", SmoothedTrajectory()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("small_angle"));
    ExpectNear(LoadJson(flight.out() / "result.json")["boresight"], 6.0);
  }
}

// ---- Bad input ---------------------------------------------------------------------------------

void ExpectError(const ProgramRun& run, int exit_code, const std::string& what) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  const std::size_t at = run.err.find("dn calibrate: error: ");
  ASSERT_NE(at, std::string::npos) << run.err;
  EXPECT_THAT(run.err.substr(at), HasSubstr(what));
}

TEST(CliGaussHelmert, WithoutATrajectoryTheFlightIsSmoothedFirst) {
  for (const char* method : {"gh", "all"}) {
    const DamagedFlight flight;
    const ProgramRun run = flight.Run("calibrate", {"--method", method});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("it is smoothed"));
    const fs::path smoothed = flight.out() / "smoothed/trajectory.out";
    EXPECT_TRUE(fs::exists(smoothed));
    EXPECT_THAT(FileContent(flight.out() / "config.resolved.yaml"), HasSubstr(smoothed.string()));
    EXPECT_TRUE(fs::exists(flight.out() / "result.json"));
  }
}

TEST(CliGaussHelmert, AMissingTrajectoryFileIsNamed) {
  const DamagedFlight flight;
  ExpectError(flight.Run("calibrate", {"--method", "gh", "--trajectory", "/no/such/file.out"}), 1,
              "/no/such/file.out does not exist");
}

TEST(CliGaussHelmert, ATrajectoryForTheNetworkIsWrongUsage) {
  for (const std::vector<std::string>& method : {std::vector<std::string>{}, {"--method", "dn"}}) {
    const DamagedFlight flight;
    std::vector<std::string> arguments{"--trajectory", SmoothedTrajectory()};
    arguments.insert(arguments.end(), method.begin(), method.end());
    ExpectError(flight.Run("calibrate", arguments), 2, "add --method gh");
  }
}

TEST(CliGaussHelmert, NeitherInertialDataNorATrajectory) {
  const DamagedFlight flight;
  RemoveImuSection(flight);
  ExpectError(flight.Run("calibrate"), 2, "neither a section 'imu'");
}

TEST(CliGaussHelmert, APairOutsideTheTrajectoryIsNamed) {
  const DamagedFlight flight;
  const std::string pairs = "lidar/" + NamesIn(flight.path() / "lidar").front();
  flight.ReplaceLine(pairs, 3, "381205, 390000, 100, 0, 0, 100, 0, 0");
  const ProgramRun run =
      flight.Run("calibrate", {"--method", "gh", "--trajectory", SmoothedTrajectory()});
  ExpectError(run, 1, "390000");
  EXPECT_THAT(run.err, HasSubstr("the trajectory"));
  EXPECT_THAT(run.err, HasSubstr(pairs + ":3"));
}

TEST(CliGaussHelmert, ADamagedTrajectoryIsNamed) {
  const DamagedFlight flight;
  const std::string sbet = FileContent(SmoothedTrajectory());
  flight.Write("trajectory.out", sbet.substr(0, 13600 + 17));
  ExpectError(flight.Run("calibrate", {"--method", "gh"}), 1, "trajectory.out");
  flight.Write("trajectory.out", sbet.substr(0, 13600));
  ExpectError(flight.Run("calibrate", {"--method", "gh"}), 1, "lies outside the trajectory");
}

TEST(CliGaussHelmert, DamagedStandardDeviationsAreNamed) {
  const DamagedFlight flight;
  fs::copy_file(SmoothedTrajectory(), flight.path() / "trajectory.out");
  flight.Write("trajectory_sigma.txt", "1, 2, 3\n");
  ExpectError(flight.Run("calibrate", {"--method", "gh"}), 1, "trajectory_sigma.txt:1");
  flight.Write("trajectory_sigma.txt", "381000, 1, 1, 1, 1, 1, 1, 1, 1, 1\n");
  ExpectError(flight.Run("calibrate", {"--method", "gh"}), 1, "trajectory_sigma.txt");
}

TEST(CliGaussHelmert, ADamagedCovarianceIsNamed) {
  const DamagedFlight flight;
  const fs::path smoothed = fs::path(SmoothedTrajectory()).parent_path();
  fs::copy_file(SmoothedTrajectory(), flight.path() / "trajectory.out");
  fs::copy_file(smoothed / "trajectory_sigma.txt", flight.path() / "trajectory_sigma.txt");
  flight.Write("trajectory_covariance.txt", "1, 2, 3\n");
  ExpectError(flight.Run("calibrate", {"--method", "gh"}), 1, "trajectory_covariance.txt:1");
  const std::string covariance = FileContent(smoothed / "trajectory_covariance.txt");
  flight.Write("trajectory_covariance.txt",
               covariance.substr(0, covariance.rfind('\n', covariance.size() - 2) + 1));
  ExpectError(flight.Run("calibrate", {"--method", "gh"}), 1, "rows are missing");
}

TEST(CliGaussHelmert, TooFewPairsAndTheSamePairAgain) {
  const DamagedFlight flight;
  const std::string pairs = "lidar/" + NamesIn(flight.path() / "lidar").front();
  const std::string all = flight.Read(pairs);
  std::string line = all.substr(0, all.find('\n') + 1);
  if (line.front() == '#') {
    const std::size_t begin = line.size();
    line = all.substr(begin, all.find('\n', begin) + 1 - begin);
  }
  const std::vector<std::string> gh{"--method", "gh", "--trajectory", SmoothedTrajectory()};
  flight.Write(pairs, line);
  ExpectError(flight.Run("calibrate", gh), 1, "at least two point pairs");
  flight.Write(pairs, line + line + line);  // equal pairs count once
  ExpectError(flight.Run("calibrate", gh), 1, "at least two point pairs");
}

TEST(CliGaussHelmert, CheckSaysWhetherItIsPossible) {
  const DamagedFlight flight;
  const ProgramRun before = RunProgram({"check", flight.path().string()});
  EXPECT_THAT(before.out, HasSubstr("a trajectory that it smooths first"));
  fs::copy_file(SmoothedTrajectory(), flight.path() / "trajectory.out");
  const ProgramRun after = RunProgram({"check", flight.path().string()});
  EXPECT_THAT(after.out, HasSubstr("dn calibrate --method gh  possible"));
  const std::string sbet = FileContent(SmoothedTrajectory());
  flight.Write("trajectory.out", sbet.substr(0, 13600));
  const ProgramRun part = RunProgram({"check", flight.path().string()});
  EXPECT_THAT(part.out,
              HasSubstr("dn calibrate --method gh  missing: pairs inside the trajectory"));
}

// ---- Reference and real data -------------------------------------------------------------------

fs::path SharedData(const std::string& name) {
  return fs::path(DN_SHARED_DATA_DIR) / "data" / name;
}

TEST(CliGaussHelmert, LiborCheck) {
  const fs::path folder = SharedData("libor-check");
  if (!fs::exists(folder)) GTEST_SKIP() << "no reference data in " << folder;
  const TempFolder out;
  const ProgramRun run =
      RunProgram({"calibrate", folder.string(), "--out", (out.path() / "r").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json libor = LoadJson(folder / "libor.json");
  const Json result = LoadJson(out.path() / "r/result.json");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(result["boresight"]["angles_deg"][i].get<double>(),
                libor["boresight_deg"][i].get<double>(), 2e-5);
    const double sigma = libor["sigma_scaled_deg"][i];
    EXPECT_NEAR(result["boresight"]["sigma_scaled_deg"][i].get<double>(), sigma, 0.01 * sigma);
  }
}

TEST(CliGaussHelmert, TentIsToldThatItHasNoPairs) {
  const fs::path folder = SharedData("tent");
  if (!fs::exists(folder)) GTEST_SKIP() << "no real data in " << folder;
  const TempFolder out;
  const ProgramRun run =
      RunProgram({"calibrate", folder.string(), "--out", (out.path() / "r").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, ::testing::HasSubstr("no file of lidar.p2p exists"));
}

}  // namespace dn::testing::apps_test
