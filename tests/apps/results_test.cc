#include <dn/axis_names.h>
#include <dn/files/flight_config.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/report/json.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "damaged_flight.h"
#include "load_json.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAre;
namespace fs = std::filesystem;

constexpr std::size_t kSbetRecordBytes = 17 * 8;

std::vector<std::string> JsonKeys(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  return keys;
}

/// Expects a list of n finite numbers.
void ExpectNumbers(const Json& json, std::size_t n) {
  ASSERT_TRUE(json.is_array()) << json.dump();
  ASSERT_EQ(json.size(), n) << json.dump();
  for (const Json& value : json) EXPECT_TRUE(value.is_number()) << json.dump();
}

void ExpectMatrix3(const Json& json) {
  ASSERT_TRUE(json.is_array()) << json.dump();
  ASSERT_EQ(json.size(), 3u);
  for (const Json& row : json) ExpectNumbers(row, 3);
}

/// Expects that the resolved configuration of a result reads back to the same configuration.
void ExpectReadsBack(const fs::path& folder) {
  const std::string text = FileContent(folder / "config.resolved.yaml");
  EXPECT_EQ(FormatFlightConfig(ParseFlightConfig(text, folder)), text);
}

void ExpectTrajectoryFiles(const fs::path& folder) {
  const std::string sbet = FileContent(folder / "trajectory.out");
  EXPECT_EQ(sbet.size() % kSbetRecordBytes, 0u);
  const Trajectory trajectory = ReadTrajectory(folder / "trajectory.out");
  EXPECT_GT(trajectory.t_end_s() - trajectory.t_begin_s(), 200.0);

  const TextTable sigma = ReadTextTable(folder / "trajectory_sigma.txt", {10});
  const TextTable biases = ReadTextTable(folder / "biases.txt", {13});
  EXPECT_EQ(sigma.rows(), biases.rows());
  for (std::size_t i = 0; i < sigma.rows(); ++i) {
    EXPECT_EQ(sigma.row(i)[0], biases.row(i)[0]);
    EXPECT_TRUE(i == 0 || sigma.row(i)[0] > sigma.row(i - 1)[0]);
    for (int c = 1; c < 10; ++c) EXPECT_GT(sigma.row(i)[c], 0.0);
    for (int c = 7; c < 13; ++c) EXPECT_GT(biases.row(i)[c], 0.0);
  }
}

void ExpectReport(const Json& report, const std::string& command) {
  EXPECT_EQ(report["command"], command);
  EXPECT_TRUE(report["error"].is_null());
  EXPECT_EQ(report["versions"]["dn"], DN_VERSION);
  EXPECT_TRUE(report["counts"].is_object());
  EXPECT_TRUE(report.contains("seed"));
  EXPECT_TRUE(report.contains("timings_s"));
}

TEST(CliResults, ReportsOfEverySubcommand) {
  ExpectReport(LoadJson(ShortFlight() / "report.json"), "simulate");
  ExpectReport(LoadJson(CheckResult() / "report.json"), "check");
  ExpectReport(LoadJson(SmoothResult() / "report.json"), "smooth");
  ExpectReport(LoadJson(CalibrateResult() / "report.json"), "calibrate");
}

TEST(CliResults, ResolvedConfigurationsReadBack) {
  ExpectReadsBack(ShortFlight());
  ExpectReadsBack(CheckResult());
  ExpectReadsBack(SmoothResult());
  ExpectReadsBack(CalibrateResult());
}

TEST(CliCheck, SummarisesAndSaysWhatIsPossible) {
  const ProgramRun run = RunProgram({"check", ShortFlight().string()});
  EXPECT_EQ(run.exit_code, 0);
  for (const char* text :
       {"flight          short", "50.00 Hz", "400 in 1 files, 2 strips",
        "dn smooth                 possible", "dn calibrate --method dn  possible",
        "verdict         ready: dn smooth, dn calibrate --method dn"}) {
    EXPECT_THAT(run.out, HasSubstr(text));
  }
}

TEST(CliSmooth, TrajectoryFiles) { ExpectTrajectoryFiles(SmoothResult()); }

TEST(CliSmooth, SmoothJson) {
  const Json smooth = LoadJson(SmoothResult() / "smooth.json");
  EXPECT_EQ(smooth["assessment"]["verdict"], "consistent");
  EXPECT_TRUE(smooth["model_check"]["p_value"].is_number());
  EXPECT_EQ(smooth["flight"], "short");
  EXPECT_TRUE(smooth["adjustment"]["converged"].get<bool>());
  const Json& innovations = smooth["innovations"]["gnss position"];
  EXPECT_TRUE(innovations["nis"].is_number());
  for (const char* axis : kEnu) {
    EXPECT_THAT(JsonKeys(innovations[axis]),
                IsSupersetOf({"mean", "variance", "expected_variance", "lag1_correlation",
                              "autocorrelation", "worst_epochs"}));
  }
}

TEST(CliSmooth, AccuracyIsThatOfTheSigmas) {
  const Json accuracy = LoadJson(SmoothResult() / "smooth.json")["accuracy"];
  const TextTable table = ReadTextTable(SmoothResult() / "trajectory_sigma.txt", {10});
  for (const auto& [key, first] : {std::pair{"enu_m", 1}, std::pair{"rph_deg", 7}}) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> sigma;
      for (std::size_t row = 0; row < table.rows(); ++row) {
        sigma.push_back(table.row(row)[first + axis]);
      }
      std::sort(sigma.begin(), sigma.end());
      const double median = accuracy[std::string("median_") + key][axis];
      EXPECT_GE(median, sigma[(sigma.size() - 1) / 2] * (1.0 - 1e-6));
      EXPECT_LE(median, sigma[sigma.size() / 2] * (1.0 + 1e-6));
      EXPECT_NEAR(accuracy[std::string("largest_") + key][axis], sigma.back(), 1e-6 * sigma.back());
    }
  }
}

TEST(CliSmooth, SaysWhetherToRelyOnItAndHowAccurateItIsFirst) {
  const TempFolder out;
  const ProgramRun run =
      RunProgram({"smooth", ShortFlight().string(), "--out", (out.path() / "smooth").string()});
  EXPECT_THAT(run.out, StartsWith("flight short: consistent"));
  const std::size_t accuracy = run.out.find("accuracy, sigmas of the adjustment\n");
  const std::size_t tables = run.out.find("innovations of the forward filter");
  ASSERT_NE(accuracy, std::string::npos);
  EXPECT_LT(accuracy, tables);
  EXPECT_LT(
      std::count(run.out.begin(), run.out.begin() + static_cast<std::ptrdiff_t>(accuracy), '\n'),
      8);
}

TEST(CliSmooth, ForwardAndReverseFilterAgreeWithinTheirNoise) {
  const Json separation = LoadJson(SmoothResult() / "smooth.json")["separation"];
  ASSERT_TRUE(separation.is_object());
  const TextTable table = ReadTextTable(SmoothResult() / "filter_separation.txt", {7});
  EXPECT_EQ(separation["epochs"], table.rows());
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 0.0, largest = 0.0;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      sum += std::pow(table.row(row)[1 + i], 2);
      largest = std::max(largest, std::abs(table.row(row)[1 + i]));
    }
    EXPECT_NEAR(separation["rms_enu_m"][i], std::sqrt(sum / static_cast<double>(table.rows())),
                1e-9);
    EXPECT_EQ(separation["max_enu_m"][i], largest);
    EXPECT_GT(separation["rms_enu_m"][i], 0.0);
    EXPECT_LT(separation["max_rph_deg"][i], 1.0);
  }
  EXPECT_THAT(FileContent(SmoothResult() / "report.html"),
              HasSubstr("Forward minus reverse filter"));
}

TEST(CliSmooth, WorstOfTheModelCheckIsThatOfTheResiduals) {
  const DamagedFlight flight;
  ASSERT_EQ(flight.Run("smooth", {"--unmodelled", "none"}).exit_code, 0);
  const Json residuals = LoadJson(flight.out() / "report.json")["residuals"];
  std::map<std::string, Json> by_name;
  for (const auto& [sensor, axes] : residuals.items()) {
    for (const auto& [axis, one] : axes.items()) {
      std::string name = fmt::format("{} {}", sensor, axis);
      std::replace(name.begin(), name.end(), '_', ' ');
      by_name[name] = one;
    }
  }
  int compared = 0;
  const Json check = LoadJson(flight.out() / "smooth.json")["model_check"];
  for (const Json& group : check["groups"]) {
    const auto one = by_name.find(group["name"]);
    if (one == by_name.end()) continue;
    ++compared;
    EXPECT_EQ(group["worst"]["standardised"], one->second["worst"]) << group["name"];
    EXPECT_EQ(group["worst"]["t_s"], one->second["worst_t_s"]) << group["name"];
  }
  EXPECT_EQ(compared, 12) << "GNSS positions and inertial increments, by axis";
}

TEST(CliCalibrate, TrajectoryFiles) { ExpectTrajectoryFiles(CalibrateResult()); }

TEST(CliCalibrate, ResultHasEveryDocumentedKey) {
  const Json result = LoadJson(CalibrateResult() / "result.json");
  EXPECT_THAT(JsonKeys(result),
              UnorderedElementsAre("schema", "flight", "method", "boresight", "assessment",
                                   "correlations", "estimates", "clocks", "adjustment",
                                   "strip_pairs", "model_check", "timing_s"));
  EXPECT_EQ(result["schema"], "dn.result/1");
  EXPECT_EQ(result["flight"], "short");
  EXPECT_EQ(result["method"], "dn");

  const Json& boresight = result["boresight"];
  for (const char* key : {"angles_deg", "euler_zyx_deg", "sigma_deg"}) {
    ExpectNumbers(boresight[key], 3);
  }
  ExpectMatrix3(boresight["covariance_deg2"]);
  ExpectMatrix3(boresight["correlation"]);
  EXPECT_TRUE(boresight.at("sigma_apriori_deg").is_null());
  EXPECT_TRUE(boresight.at("sigma_scaled_deg").is_null());

  EXPECT_THAT(result["assessment"]["verdict"].get<std::string>(),
              AnyOf("calibrated", "absorbed", "not_observable"));
  EXPECT_TRUE(result["assessment"]["reasons"].is_array());
  EXPECT_THAT(JsonKeys(result["model_check"]),
              IsSupersetOf({"groups", "effects", "p_value", "findings", "unseen"}));
  for (const char* key : {"angles_deg", "sigma_deg"})
    ExpectNumbers(boresight["as_modelled"][key], 3);
  ExpectMatrix3(boresight["as_modelled"]["covariance_deg2"]);
  ExpectMatrix3(boresight["as_modelled"]["correlation"]);
  ASSERT_FALSE(boresight["contributions"].empty());
  for (const Json& part : boresight["contributions"]) {
    EXPECT_THAT(JsonKeys(part), UnorderedElementsAre("effect", "unit", "estimate", "sigma", "prior",
                                                     "sigma_deg", "remedy"));
    ExpectNumbers(part["sigma_deg"], 3);
  }
  EXPECT_THAT(FileContent(CalibrateResult() / "report.html"),
              HasSubstr("What the sensors leave unsaid"));
  for (const Json& departure : result["model_check"]["departures"]) {
    EXPECT_THAT(JsonKeys(departure),
                UnorderedElementsAre("name", "statistic", "dof", "p_value", "boresight_damage_mdeg",
                                     "damage_sigmas"));
    EXPECT_GT(departure["p_value"], 1e-3);
  }
  EXPECT_EQ(result["model_check"]["departures"].size(), 2u);
  EXPECT_THAT(FileContent(CalibrateResult() / "report.html"),
              HasSubstr("Differences of laser vectors that no effect explains"));
  ASSERT_FALSE(result["model_check"]["groups"].empty());
  EXPECT_THAT(JsonKeys(result["model_check"]["groups"][0]),
              UnorderedElementsAre("name", "observations", "redundancy", "variance_ratio",
                                   "p_value", "worst"));
  for (const char* bias : {"boresight_to_accel_bias", "boresight_to_gyro_bias"}) {
    ExpectMatrix3(result["correlations"][bias]["at_barycentre"]);
    EXPECT_TRUE(result["correlations"][bias]["max_abs"].is_number());
    EXPECT_TRUE(result["correlations"][bias]["rms"].is_number());
  }
  EXPECT_TRUE(result["estimates"].is_object());
  EXPECT_THAT(JsonKeys(result["clocks"]), UnorderedElementsAre("gnss", "lidar"));
  EXPECT_THAT(JsonKeys(result["clocks"]["gnss"]),
              UnorderedElementsAre("offset_s", "sigma_offset_s", "drift_ppm", "sigma_drift_ppm",
                                   "correlation"));
  const Json& adjustment = result["adjustment"];
  for (const char* key : {"sigma0", "chi2", "redundancy", "condition_number", "iterations",
                          "residual_initial_m", "residual_final_m", "nodes", "parameters",
                          "imu_epochs", "gnss_epochs", "correspondences", "outliers"}) {
    EXPECT_TRUE(adjustment.contains(key) && adjustment[key].is_number()) << key;
  }
  EXPECT_TRUE(adjustment["converged"].get<bool>());
  for (const char* key : {"read", "solve", "covariance", "total"}) {
    EXPECT_TRUE(result["timing_s"][key].is_number()) << key;
  }
}

TEST(CliCalibrate, SigmaIsTheRootOfTheCovariance) {
  const Json boresight = LoadJson(CalibrateResult() / "result.json")["boresight"];
  constexpr double kRounding = 1e-12;  // rounding error of one square root
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma = boresight["sigma_deg"][i];
    EXPECT_NEAR(sigma, std::sqrt(boresight["covariance_deg2"][i][i].get<double>()),
                kRounding * sigma);
  }
}

TEST(CliCalibrate, FindsTheSimulatedBoresight) {
  const Json boresight = LoadJson(CalibrateResult() / "result.json")["boresight"];
  const double truth_deg[] = {0.2, 0.03, 0.35};
  // The false-alarm probability is below 1e-5 per angle, and the seed is fixed.
  constexpr double kSigmas = 4.5;
  // Largest useful error, deg: a tenth of the angles.
  constexpr double kUsefulDeg = 0.03;
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma = boresight["sigma_deg"][i];
    EXPECT_NEAR(boresight["angles_deg"][i].get<double>(), truth_deg[i], kSigmas * sigma);
    EXPECT_LT(sigma, kUsefulDeg);
  }
}

TEST(CliCalibrate, TheSmoothedTrajectoryIsNearTheTrueOne) {
  const Json errors = LoadJson(CalibrateResult() / "report.json")["reference_errors"];
  // The GNSS sigmas are 1.5 cm and 3 cm, and the inertial unit is of navigation grade.
  constexpr double kPositionM = 0.05;
  constexpr double kRollPitchDeg = 0.02;
  for (const Json& rmse_m : errors["position_enu_rmse_m"]) EXPECT_LT(rmse_m, kPositionM);
  EXPECT_LT(errors["roll_pitch_heading_rmse_deg"][0], kRollPitchDeg);
  EXPECT_LT(errors["roll_pitch_heading_rmse_deg"][1], kRollPitchDeg);
}

}  // namespace dn::testing::apps_test
