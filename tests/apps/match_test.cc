#include <dn/files/flight.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/mounting.h>
#include <dn/lidar/pairs.h>
#include <dn/lidar/strip_io.h>
#include <dn/report/json.h>
#include <dn/rotation.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "between_pairs.h"
#include "page_numbers.h"
#include "run_program.h"
#include "strip_scenario.h"
#include "testing/las_bytes.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

int CountPairs(const std::string& part, const std::string& text) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

class Matching : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TempFolder>();
    folder_->Write("town.yaml", StripScenario("kind: built_up, roughness_m: 0.2"));
    const ProgramRun run =
        RunProgram({"simulate", In("town.yaml"), "--seed", "2", "--out", In("flight")});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    fs::remove_all(folder_->path() / "flight" / "lidar");
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string In(const std::string& name) { return (folder_->path() / name).string(); }
  static Json Read(const std::string& name) { return Json::parse(FileContent(In(name))); }
  static void ExpectNewStrips(const std::string& folder);

  static std::unique_ptr<TempFolder> folder_;
};

std::unique_ptr<TempFolder> Matching::folder_;

using MatchingManyRuns = Matching;

TEST_F(Matching, PairsOfStripsCalibrateTheFlight) {
  const ProgramRun match = RunProgram({"match", In("flight"), "--out", In("matched")});
  ASSERT_EQ(match.exit_code, 0) << match.err;
  const Json counts = Read("matched/match.json")["counts"];
  EXPECT_GT(counts["pairs"].get<int>(), 20);
  EXPECT_GE(counts["registered"].get<int>(), counts["pairs"].get<int>());
  EXPECT_TRUE(fs::exists(In("matched/lidar/1_2.txt")));
  ExpectPageMatchesFiles(In("matched"), 40);
  const Json plants = Read("matched/match.json")["plant_offset"];
  EXPECT_LT(plants["share"].get<double>(), 0.5);
  EXPECT_LT(std::abs(plants["offset_m"].get<double>()), 4.0 * plants["sigma_m"].get<double>());
  // Smooth roofs and ground without plants leave hardly anything to share.
  EXPECT_LT(plants["share"].get<double>() * plants["sigma_m"].get<double>(), 0.005);
  const Json swaths = Read("matched/swaths.json")["swaths"];
  ASSERT_EQ(swaths.size(), 2u);
  EXPECT_EQ(swaths[0]["line_en_m"].size(), 60u);
  EXPECT_GT(swaths[0]["outline_en_m"].size(), 6u);
  EXPECT_EQ(Read("matched/report.json")["inputs"].back()["file"], "strips/2.las");

  const ProgramRun calibrate =
      RunProgram({"calibrate", In("matched/flight.matched.yaml"), "--out", In("calibrated")});
  ASSERT_EQ(calibrate.exit_code, 0) << calibrate.err;
  const Json boresight = Read("calibrated/result.json")["boresight"];
  const double truth_deg[] = {0.2, 0.03, 0.35};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(boresight["angles_deg"][i].get<double>(), truth_deg[i],
                4.0 * boresight["sigma_deg"][i].get<double>());
  }
}

/// Renames the extra bytes of the laser vectors, so that no reader finds them.
void HideVectors(const fs::path& las) {
  std::string bytes = FileContent(las);
  for (const std::string name : {"ux", "uy", "uz"}) {
    const std::size_t at = bytes.find(name + std::string(30, '\0'));
    ASSERT_NE(at, std::string::npos) << name;
    bytes[at] = 'q';
  }
  std::ofstream(las, std::ios::binary) << bytes;
}

TEST_F(MatchingManyRuns, VectorsOfAnAssumedBoresightDoNotCalibrate) {
  fs::copy(In("flight"), In("bare_points"), fs::copy_options::recursive);
  for (const char* name : {"1.las", "2.las"}) {
    HideVectors(folder_->path() / "bare_points/strips" / name);
  }
  constexpr double truth_deg = 0.2;
  const auto calibrate = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"calibrate", In("bare_points"),
                                       "--out",     In("from_points"),
                                       "--set",     "lidar.boresight_deg=[1, 0, 0]"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  };
  const auto roll_deg = [](const Json& result) {
    return result["boresight"]["angles_deg"][0].get<double>();
  };
  // The points of a simulated flight are computed with a boresight of zero.
  const ProgramRun assumed = calibrate({});
  EXPECT_EQ(assumed.exit_code, 0) << assumed.err;
  EXPECT_THAT(assumed.err, HasSubstr("1.las (as 1 more) has no laser vectors"));
  const std::string first_line = FileContent(In("from_points/lidar/1_2.txt")).substr(0, 80);
  EXPECT_THAT(first_line,
              StartsWith("# laser vectors computed with boresight 1, 0, 0 deg: assumed"));
  const Json wrong = Read("from_points/result.json");
  EXPECT_EQ(wrong["assessment"]["verdict"], "absorbed");
  EXPECT_THAT(wrong["assessment"]["reasons"][0].get<std::string>(),
              HasSubstr("the laser vectors of 1_2.txt were computed from points"));
  EXPECT_NEAR(roll_deg(wrong), truth_deg + 1.0, 0.05);

  const ProgramRun declared =
      calibrate({"--set", "lidar.georeferenced_with={boresight_deg: [0, 0, 0]}"});
  EXPECT_EQ(declared.exit_code, 0) << declared.err;
  EXPECT_THAT(declared.err, Not(HasSubstr("has no laser vectors")));
  const Json right = Read("from_points/result.json");
  EXPECT_EQ(right["assessment"]["verdict"], "calibrated");
  EXPECT_NEAR(roll_deg(right), truth_deg, 4.0 * right["boresight"]["sigma_deg"][0].get<double>());
}

TEST_F(MatchingManyRuns, AllMethodsRunFromStripsAlone) {
  const ProgramRun run =
      RunProgram({"calibrate", In("flight"), "--method", "all", "--out", In("all")});
  EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 1) << run.err;
  const Json comparison = Read("all/comparison.json");
  EXPECT_TRUE(fs::exists(In("all/result_dn.json")));
  EXPECT_TRUE(fs::exists(In("all/result_gh.json")));
  EXPECT_EQ(FileContent(In("all/result.json")), FileContent(In("all/result_dn.json")));
  EXPECT_THAT(run.out, HasSubstr("use the angles of dn"));
  EXPECT_TRUE(fs::exists(In("all/match.json")));
  EXPECT_TRUE(fs::exists(In("all/lidar/1_2.txt")));
  ExpectPageMatchesFiles(In("all"), 200);
  EXPECT_THAT(FileContent(In("all/config.resolved.yaml")), HasSubstr(In("all/lidar/1_2.txt")));
  // The GNSS screening runs once without pairs, for matching and planes, and once with them.
  EXPECT_EQ(CountPairs("dn calibrate: GNSS screening", run.err), 2) << run.err;
}

/// Returns the mean distance between the pairs of a result's points.
double MeanShift(const Json& georef) {
  double sum = 0.0;
  for (const Json& strip : georef["strips"]) sum += strip["shift_rms_m"].get<double>();
  return sum / static_cast<double>(georef["strips"].size());
}

TEST_F(MatchingManyRuns, OneCommandLeadsFromStripsToCorrectedStrips) {
  const ProgramRun run = RunProgram({"calibrate", In("flight"), "--georef", "--out", In("clouds")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json one = Read("clouds/georef.json");
  EXPECT_EQ(one["trajectory"], In("clouds/trajectory.out"));
  EXPECT_GT(MeanShift(one), 0.0);
  // The same in two commands, with the adjusted trajectory found beside the result.
  const ProgramRun second = RunProgram(
      {"georef", In("flight"), "--result", In("clouds/result.json"), "--out", In("clouds_2")});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  const Json two = Read("clouds_2/georef.json");
  EXPECT_EQ(two["trajectory"], In("clouds/trajectory.out"));
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(two["boresight_deg"][k].get<double>(), one["boresight_deg"][k].get<double>(),
                1e-12);
  }
  ASSERT_EQ(two["strips"].size(), one["strips"].size());
  for (std::size_t k = 0; k < one["strips"].size(); ++k) {
    EXPECT_NEAR(two["strips"][k]["shift_rms_m"].get<double>(),
                one["strips"][k]["shift_rms_m"].get<double>(), 1e-6);
  }
}

/// Two opposite lines 120 m apart, 1500 m long. They hardly separate yaw from pitch.
constexpr const char* kOpposite = R"(
name: opposite
origin_deg_m: [46.57, 6.52, 0]
start_s: 381000
plan:
  warm_up_s: 300
  lines:
    - [-750, 0, 750, 0, 700, 45]
    - [750, 120, -750, 120, 700, 45]
  bank_deg: 25
  turbulence: {roll_deg: 1.0, pitch_deg: 0.7, heading_deg: 0.7, speed_m_s: 1.0, height_m: 2.0}
terrain: {kind: mixed, base_m: 525, relief_m: 60, wavelength_m: 900, buildings_per_km2: 300,
          trees_per_km2: 0, seed: 1}
imu: {rate_hz: 200, preset: airins}
gnss: {rate_hz: 1, sigma_enu_m: [0.015, 0.015, 0.03], lever_arm_m: [0.4, -0.1, -1.1]}
lidar:
  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
  scan_axis: [0, 1, 0]
  nadir_axis: [1, 0, 0]
  lever_arm_m: [0.14, -0.02, 0.21]
  boresight_deg: [0.2, 0.03, 0.35]
  fov_deg: 75
  pulse_rate_hz: 10000
  gsd_m: 1.1
pairs: {count: 100}
strips: true
)";

TEST_F(MatchingManyRuns, OppositeStripsAreMatchedFromAnUnknownBoresight) {
  folder_->Write("opposite.yaml", kOpposite);
  ASSERT_EQ(RunProgram({"simulate", In("opposite.yaml"), "--out", In("opposite")}).exit_code, 0);
  const ProgramRun run = RunProgram({"match", In("opposite"), "--out", In("opposite_matched")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json match = Read("opposite_matched/match.json");
  EXPECT_GT(match["counts"]["pairs"], 40);
  EXPECT_LT(match["misalignment"]["after"]["rms_m"], 0.3);
  EXPECT_NEAR(match["boresight_used_deg"][0].get<double>(), 0.2, 0.02);
  EXPECT_NEAR(match["boresight_used_deg"][1].get<double>(), 0.03, 0.1);
  EXPECT_NEAR(match["boresight_used_deg"][2].get<double>(), 0.35, 0.3);
}

// Smooth fields between the houses have no pairs, but heights.
TEST_F(MatchingManyRuns, SmoothCellsAreSurfacePairsOfTheFlight) {
  folder_->Write("opposite.yaml", kOpposite);
  ASSERT_EQ(RunProgram({"simulate", In("opposite.yaml"), "--out", In("fields")}).exit_code, 0);
  ASSERT_EQ(RunProgram({"match", In("fields"), "--out", In("fields_matched")}).exit_code, 0);
  const Json match = Read("fields_matched/match.json");
  const long surfaces = match["counts"]["surface_pairs"];
  EXPECT_GT(surfaces, 20);
  EXPECT_TRUE(fs::exists(In("fields_matched/surfaces/1_2.txt")));
  EXPECT_TRUE(fs::exists(In("fields_matched/surface_matches/1_2.txt")));
  const ProgramRun run = RunProgram(
      {"calibrate", In("fields_matched/flight.matched.yaml"), "--out", In("fields_result")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("surface pairs kept"));
  const Json result = Read("fields_result/result.json");
  const Json& adjustment = result["adjustment"];
  EXPECT_EQ(adjustment["surface_pairs"].get<long>() + adjustment["surface_outliers"].get<long>(),
            surfaces);
  EXPECT_LT(adjustment["surface_outliers"].get<long>(), 5);
  const double truth_deg[] = {0.2, 0.03, 0.35};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(result["boresight"]["angles_deg"][i].get<double>(), truth_deg[i],
                4.0 * result["boresight"]["sigma_deg"][i].get<double>());
  }
}

TEST_F(MatchingManyRuns, PlanesAreFoundFromFarOff) {
  const std::string terrain =
      "terrain={kind: built_up, roughness_m: 0.01, relief_m: 40, wavelength_m: 250, "
      "buildings_per_km2: 800, seed: 3}";
  ASSERT_EQ(
      RunProgram({"simulate", In("town.yaml"), "--seed", "3", "--set",
                  "lidar.boresight_deg=[4.1, -3.7, 4.4]", "--set", terrain, "--out", In("far")})
          .exit_code,
      0);
  const ProgramRun run = RunProgram({"calibrate", In("far"), "--method", "planes", "--trajectory",
                                     In("far/reference.out"), "--out", In("far_planes")});
  ASSERT_TRUE(fs::exists(In("far_planes/result.json"))) << run.err;
  const Json angles = Read("far_planes/result.json")["boresight"]["angles_deg"];
  const double truth_deg[] = {4.1, -3.7, 4.4};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(angles[i].get<double>(), truth_deg[i], 0.1);
}

const Eigen::Vector3d kBoresight_deg(0.2, 0.03, 0.35);
const Eigen::Vector3d kEveningBoresight_deg(-2.4, 3.5, 2.1);

/// Simulates a second flight over the same ground, with another boresight.
void SimulateEvening(const fs::path& folder) {
  const ProgramRun run = RunProgram(
      {"simulate", (folder / "town.yaml").string(), "--seed", "5", "--set", "name=evening", "--set",
       "lidar.boresight_deg=[-2.4, 3.5, 2.1]", "--out", (folder / "evening").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(MatchingManyRuns, StripsOfTwoFlightsAreMatchedWithEachOther) {
  if (!fs::exists(In("evening"))) SimulateEvening(folder_->path());
  const ProgramRun run = RunProgram({"match", In("flight"), In("evening"), "--out", In("between")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json match = Read("between/match.json");
  EXPECT_EQ(match["flights"][1]["name"], "evening");
  EXPECT_EQ(match["strip_pairs"].size(), 4u);
  for (const Json& strips : match["strip_pairs"]) {
    EXPECT_THAT(strips["strips"][0].get<std::string>(), StartsWith("short_"));
    EXPECT_THAT(strips["strips"][1].get<std::string>(), StartsWith("evening_"));
  }
  const TrueFlight first(In("flight"), kBoresight_deg);
  const TrueFlight second(In("evening"), kEveningBoresight_deg);
  double chi2 = 0.0;
  const PairData between = ReadPairs(In("between"), {"between_short_evening/*.txt"});
  EXPECT_EQ(between.pairs.size(), match["counts"]["pairs"].get<std::size_t>());
  ASSERT_GT(between.pairs.size(), 50u);
  for (const LidarPair& pair : between.pairs) {
    const Eigen::Vector3d apart_m =
        first.Ground(pair.t_i_s, pair.u_i_s) - second.Ground(pair.t_j_s, pair.u_j_s);
    EXPECT_LT(apart_m.norm(), 0.7);
    // The axes of the covariance are those of the map frame; its trace does not depend on them.
    chi2 += 3.0 * apart_m.squaredNorm() / pair.covariance_m2->trace();
  }
  const double ratio = chi2 / 3.0 / static_cast<double>(between.pairs.size());
  EXPECT_GT(ratio, 0.3);
  EXPECT_LT(ratio, 2.0);
}

TEST_F(MatchingManyRuns, AFlightOfOneStripIsAlignedByTheOther) {
  if (!fs::exists(In("evening"))) SimulateEvening(folder_->path());
  fs::copy(In("evening"), In("single"), fs::copy_options::recursive);
  fs::remove(In("single/strips/2.las"));
  const ProgramRun run = RunProgram({"match", In("flight"), In("single"), "--out", In("aligned")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json match = Read("aligned/match.json");
  ASSERT_EQ(match["strip_pairs"].size(), 2u);
  EXPECT_GT(match["counts"]["pairs"].get<int>(), 30);
  const Eigen::Vector3d truth_deg[] = {kBoresight_deg, kEveningBoresight_deg};
  for (std::size_t k = 0; k < 2; ++k) {
    const Json& used_deg = match["flights"][k]["boresight_used_deg"];
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(used_deg[i].get<double>(), truth_deg[k][i], 0.05) << k << ", " << i;
    }
  }
}

TEST_F(MatchingManyRuns, FlightsOfOneStripAreAlignedTogether) {
  if (!fs::exists(In("evening"))) SimulateEvening(folder_->path());
  for (const char* name : {"flight", "evening"}) {
    const std::string copy = In(std::string("one_strip_of_") + name);
    fs::copy(In(name), copy, fs::copy_options::recursive);
    fs::remove(copy + "/strips/2.las");
  }
  const ProgramRun run = RunProgram(
      {"match", In("one_strip_of_flight"), In("one_strip_of_evening"), "--out", In("together")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json match = Read("together/match.json");
  EXPECT_GT(match["counts"]["pairs"].get<int>(), 30);
  EXPECT_GT(match["misalignment"]["before"]["rms_m"].get<double>(), 5.0);
  EXPECT_LT(match["misalignment"]["after"]["rms_m"].get<double>(), 0.3);
}

TEST_F(Matching, FlightsNeedTheirOwnNamesAndTrajectories) {
  const ProgramRun names = RunProgram({"match", In("flight"), In("flight"), "--out", In("twice")});
  EXPECT_EQ(names.exit_code, 2);
  EXPECT_THAT(names.err, HasSubstr("two flights have the name short"));
  const ProgramRun path = RunProgram({"match", In("flight"), ShortFlight().string(), "--trajectory",
                                      In("flight/reference.out"), "--out", In("twice")});
  EXPECT_EQ(path.exit_code, 2);
  EXPECT_THAT(path.err, HasSubstr("--trajectory is for one flight"));
}

TEST_F(Matching, BareStripsGivePositions) {
  const ProgramRun run = RunProgram({"match", In("flight/strips/1.las"), In("flight/strips/2.las"),
                                     "--gsd", "0.7", "--search-m", "8", "--out", In("bare")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(In("bare/pairs_xyz.txt")));
  EXPECT_GT(Read("bare/match.json")["counts"]["pairs"].get<int>(), 5);
  EXPECT_TRUE(Read("bare/swaths.json")["swaths"][0]["line_en_m"].empty());
}

TEST_F(Matching, ADistanceFarBelowThatOfThePointsIsRefused) {
  for (const char* gsd : {"1e-9", "1e-3"}) {
    ProgramOptions options;
    options.arguments = {
        "match",   In("flight/strips/1.las"), In("flight/strips/2.las"), "--gsd", gsd, "--out",
        In("fine")};
    options.max_memory_bytes = 2L << 30;
    const ProgramRun run = RunProgram(options);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr("one point per"));
    EXPECT_THAT(run.err, HasSubstr("1.las"));
  }
}

TEST_F(Matching, AValueOfTheFlightCanBeReplaced) {
  const ProgramRun unknown =
      RunProgram({"match", In("flight"), "--set", "strips_crs=none", "--out", In("replaced")});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("strips_crs is 'none'"));
  const ProgramRun bare = RunProgram({"match", In("flight/strips/1.las"), In("flight/strips/2.las"),
                                      "--set", "strips_crs=map", "--out", In("replaced")});
  EXPECT_EQ(bare.exit_code, 2);
  EXPECT_THAT(bare.err, HasSubstr("strips alone have none"));
}

TEST_F(Matching, AFlightWithoutStripsIsToldWhereTheyBelong) {
  const ProgramRun run = RunProgram({"match", ShortFlight().string(), "--out", In("none")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("the flight has no strips; put point clouds"));
}

TEST_F(Matching, FlatGroundIsAnHonestShortage) {
  folder_->Write("flat.yaml", StripScenario("kind: flat, roughness_m: 0"));
  ASSERT_EQ(RunProgram({"simulate", In("flat.yaml"), "--out", In("flat")}).exit_code, 0);
  const ProgramRun run = RunProgram({"match", In("flat"), "--out", In("flat_matched")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("no correspondence was found"));
  EXPECT_EQ(Read("flat_matched/match.json")["counts"]["pairs"].get<int>(), 0);
}

TEST(CliMatchLimits, ASearchWithoutEnd) {
  for (const auto& [option, value] : {std::pair("--search-deg", "1e9"),
                                      {"--search-m", "1e12"},
                                      {"--max-pairs", "1000000000000"}}) {
    const ProgramRun run = RunProgram({"match", ShortFlight(), option, value, "--out", "unused"});
    EXPECT_EQ(run.exit_code, 2) << option;
    EXPECT_THAT(run.err, HasSubstr(option));
  }
}

TEST_F(Matching, CheckSaysThatStripsAreMatchedForACalibration) {
  const ProgramRun check = RunProgram({"check", In("flight")});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out,
              HasSubstr("dn calibrate --method dn  possible: boresight from the pairs of "
                        "the strips, which it matches first"));
  EXPECT_THAT(check.out,
              HasSubstr("dn calibrate --method gh  possible: boresight from the pairs of "
                        "the strips, which it matches first on a trajectory that it "
                        "smooths first"));
}

/// Copies the measurements of a flight alone, and describes them by dn init.
std::string Described(const fs::path& flight, const fs::path& raw,
                      const std::vector<std::string>& folders) {
  fs::create_directory(raw);
  for (const char* name : {"IMU.txt", "GPS.txt"}) fs::copy(flight / name, raw / name);
  for (const std::string& name : folders) fs::copy(flight / name, raw / name);
  const ProgramRun init = RunProgram({"init", raw.string()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(init.out, HasSubstr(folders.back() + "/1.las"));
  EXPECT_THAT(init.out, Not(HasSubstr("no pairs")));
  return FileContent(raw / "flight.yaml");
}

TEST_F(Matching, InitDescribesTheScannerByItsStrips) {
  const std::string yaml = Described(In("flight"), In("raw"), {"strips"});
  EXPECT_THAT(yaml, HasSubstr("\n  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\n"));
  EXPECT_THAT(yaml, HasSubstr("\n  scan_axis: [0, 1, 0]\n  nadir_axis: [1, 0, 0]\n"));
  EXPECT_THAT(yaml, HasSubstr("from -37.5 to 37.5 deg"));
  const ProgramRun check = RunProgram({"check", In("raw")});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("dn match                  possible"));
}

/// A folder of the measurements of a flight and its strips in UTM, without a flight.yaml.
class RawFlight {
 public:
  RawFlight(const fs::path& flight, const fs::path& raw) : flight_(flight), raw_(raw) {
    fs::create_directories(raw / "strips");
    for (const char* name : {"IMU.txt", "GPS.txt"}) fs::copy(flight / name, raw / name);
  }

  void AddTrajectory() { fs::copy(flight_ / "reference.out", raw_ / "trajectory.out"); }

  /// Writes every fifth point of a strip with its laser vector, turned by R_xs from the scanner.
  /// One of 97 points is wrong.
  void AddText(const Eigen::Matrix3d& R_xs) const {
    std::ofstream text(raw_ / "strips/1.txt");
    int points = 0;
    ForPoints([&](double t_s, const Eigen::Vector3d& p_c, const Eigen::Vector3d& u_s) {
      const Eigen::Vector3d u_x = R_xs * u_s;
      const Eigen::Vector3d wrong_m = ++points % 97 == 0 ? Eigen::Vector3d(90, -60, 150)
                                                         : Eigen::Vector3d(Eigen::Vector3d::Zero());
      text << FormatDouble(t_s);
      for (const Eigen::Vector3d& v : {Eigen::Vector3d(p_c + wrong_m), u_x}) {
        for (int i = 0; i < 3; ++i) text << ", " << FormatDouble(v[i]);
      }
      text << '\n';
    });
  }

  /// Writes the same points as a LAS file without laser vectors.
  void AddLas() const {
    LasBytes las;
    las.offset[1] = 5e6;
    ForPoints([&](double t_s, const Eigen::Vector3d& p_c, const Eigen::Vector3d&) {
      const auto steps = [&](double x) {
        return static_cast<std::int32_t>(std::lround(x / las.scale));
      };
      las.points.push_back(
          {steps(p_c.x()), steps(p_c.y() - 5e6), steps(p_c.z()), t_s, 5, 1, 1, ""});
    });
    std::ofstream(raw_ / "strips/1.las", std::ios::binary) << las.Build();
  }

  /// Returns the flight.yaml of dn init.
  std::string Init() const {
    const ProgramRun init = RunProgram({"init", raw_.string()});
    EXPECT_EQ(init.exit_code, 0) << init.err;
    EXPECT_EQ(RunProgram({"check", raw_.string()}).exit_code, 0);
    return FileContent(raw_ / "flight.yaml");
  }

 private:
  template <class Take>
  void ForPoints(const Take& take) const {
    const PointCrs crs("utm:32n", ReadFlight(flight_, {.trajectory = false}).frame);
    const auto strip = OpenStrip(flight_ / "strips/1.las");
    for (StripCloud points; strip->Next(&points);) {
      for (std::size_t k = 0; k < points.size(); k += 5) {
        take(points.t_s[k], crs.FromMap(points.p_c[k]), points.u_s[k]);
      }
    }
  }

  fs::path flight_, raw_;
};

TEST_F(Matching, InitFindsTheMountingByTheTrajectory) {
  RawFlight raw(In("flight"), In("raw_mounting"));
  raw.AddTrajectory();
  Eigen::Matrix3d R_xs;  // the scanner lies on its side
  R_xs << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  raw.AddText(R_xs);
  const std::string yaml = raw.Init();
  EXPECT_THAT(yaml,
              HasSubstr("# This mounting leads from the laser vectors to the points, to 0.0"));
  EXPECT_THAT(yaml, HasSubstr("\n  R_sensor_to_body: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]\n"));
  EXPECT_THAT(yaml, HasSubstr("\n  scan_axis: [0, 1, 0]\n  nadir_axis: [0, 0, 1]\n"));
  EXPECT_THAT(yaml, HasSubstr("\nstrips_crs: utm:32n "));
  EXPECT_THAT(yaml, HasSubstr("\n  gsd_m: 2."));
}

TEST_F(Matching, InitGuessesTheMountingByTheCourse) {
  RawFlight raw(In("flight"), In("raw_course"));
  raw.AddText(Eigen::Matrix3d::Identity());
  const std::string yaml = raw.Init();
  EXPECT_THAT(yaml, HasSubstr("# GUESS: with this mounting, the laser vectors lead to the points"));
  EXPECT_THAT(yaml, HasSubstr("\n  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\n"));
}

TEST_F(Matching, InitDescribesStripsWithoutLaserVectors) {
  RawFlight raw(In("flight"), In("raw_las"));
  raw.AddTrajectory();
  raw.AddLas();
  const std::string yaml = raw.Init();
  EXPECT_THAT(yaml, HasSubstr("# The points have no laser vectors."));
  EXPECT_THAT(yaml, HasSubstr("\n  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\n"));
  EXPECT_THAT(yaml, HasSubstr("georeferenced_with: {boresight_deg: [0, 0, 0]}   # MISSING"));
  folder_->Write("raw_las/flight.yaml", With(yaml, "# georeferenced_with", "georeferenced_with"));
  const ProgramRun match = RunProgram({"match", In("raw_las"), "--out", In("raw_las_matched")});
  EXPECT_THAT(match.err, HasSubstr("two strips or more"));  // nothing else is missing
}

// Measured strips of a scanner with 32 beams, whose provider states the mounting.
TEST(InitOfMeasuredStrips, FindsTheStatedMounting) {
  const fs::path tent = fs::path(DN_SHARED_DATA_DIR) / "data/tent";
  if (!fs::exists(tent)) GTEST_SKIP() << tent << " is absent";
  const TempFolder folder;
  fs::copy(tent / "strips", folder.path() / "strips");
  fs::copy(tent / "trajectory.txt", folder.path() / "trajectory.txt");
  const ProgramRun init = RunProgram({"init", folder.path().string()});
  ASSERT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(init.out, Not(HasSubstr("missing  lidar")));
  const Mounting stated = ReadFlightConfig(tent).lidar->mounting;
  const Mounting found = ReadFlightConfig(folder.path()).lidar->mounting;
  EXPECT_EQ(found.R_bs_nominal, stated.R_bs_nominal);
  EXPECT_LT((found.lever_arm_b_m - stated.lever_arm_b_m).norm(), 0.005);
  EXPECT_LT((found.boresight_rad - stated.boresight_rad).norm(), 0.005 * kRadPerDeg);
}

TEST_F(Matching, InitDescribesEveryScannerWithAFolder) {
  fs::create_directory(In("copies"));
  for (const char* name : {"IMU.txt", "GPS.txt"}) {
    fs::copy(fs::path(In("flight")) / name, fs::path(In("copies")) / name);
  }
  for (const char* name : {"strips_left", "strips_right"}) {
    fs::copy(In("flight") + "/strips", fs::path(In("copies")) / name);
  }
  const std::string yaml = Described(In("copies"), In("raw_two"), {"strips_left", "strips_right"});
  EXPECT_THAT(yaml, HasSubstr("\n  - name: \"left\"\n"));
  EXPECT_THAT(yaml, HasSubstr("\n  - name: \"right\"\n"));
  const ProgramRun check = RunProgram({"check", In("raw_two")});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("strips_right/2.las: "));
}

constexpr const char* kTwoScanners =
    "lidar=[{name: a, R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]], scan_axis: [0, 1, 0], "
    "nadir_axis: [1, 0, 0], boresight_deg: [0.2, 0.03, 0.35], fov_deg: 75, gsd_m: 0.7, "
    "pulse_rate_hz: 14000}, {name: b, R_sensor_to_body: [[0.342020143326, 0.939692620786, 0], "
    "[0, 0, 1], [0.939692620786, -0.342020143326, 0]], scan_axis: [0, 1, 0], nadir_axis: [1, 0, "
    "0], "
    "lever_arm_m: [0.3, 0, 0.1], boresight_deg: [-0.4, 0.5, 0.1], fov_deg: 75, gsd_m: 0.7, "
    "pulse_rate_hz: 14000}]";

/// Checks the new strips of both scanners: their boresights, and that their heights agree.
void Matching::ExpectNewStrips(const std::string& folder) {
  for (const char* strip : {"/strips_a/1.las", "/strips_a/2.las", "/strips_b/1.las"}) {
    EXPECT_TRUE(fs::exists(In(folder) + strip)) << strip;
  }
  const Json result = Read("two_result/result.json"), georef = Read(folder + "/georef.json");
  for (std::size_t k = 0; k < 2; ++k) {
    const Json& angles_deg = result["scanners"][k]["boresight"]["angles_deg"];
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(georef["scanners"][k]["boresight_deg"][i].get<double>(),
                  angles_deg[i].get<double>(), 1e-9);
    }
  }
  ASSERT_EQ(georef["strip_differences"].size(), 6u);  // of every two of four strips
  const Json& between = georef["strip_differences"][1];
  EXPECT_EQ(between["raster"], "differences/a_1-b_1.asc");
  EXPECT_GT(between["before"]["rms_m"].get<double>(), 0.5);
  EXPECT_LT(between["after"]["rms_m"].get<double>(), 0.05);
}

TEST_F(MatchingManyRuns, StripsOfTwoScannersGiveTheirRelativeBoresight) {
  const ProgramRun simulate =
      RunProgram({"simulate", In("town.yaml"), "--set", kTwoScanners, "--set",
                  "pairs={count: 0, between: 0}", "--seed", "2", "--out", In("two")});
  ASSERT_EQ(simulate.exit_code, 0) << simulate.err;
  EXPECT_THAT(simulate.out, HasSubstr(" points of a, "));
  const ProgramRun check = RunProgram({"check", In("two")});
  EXPECT_THAT(check.out, HasSubstr("strips_b/1.las: "));
  EXPECT_THAT(check.out, HasSubstr("gh  missing: the choice of a scanner (--scanner)"));
  EXPECT_THAT(check.out, HasSubstr("dn  possible: boresight, boresight/b from the pairs of"));
  const ProgramRun match = RunProgram({"match", In("two"), "--out", In("two_matched")});
  ASSERT_EQ(match.exit_code, 0) << match.err;
  EXPECT_THAT(match.out, HasSubstr("a_1-b_1"));
  EXPECT_TRUE(fs::exists(In("two_matched/lidar_a/1_2.txt")));
  EXPECT_TRUE(fs::exists(In("two_matched/lidar_b/1_2.txt")));
  EXPECT_TRUE(fs::exists(In("two_matched/lidar_a_b/1_2.txt")));
  const Json matched = Read("two_matched/match.json");
  EXPECT_EQ(matched["strips"].size(), 4u);
  EXPECT_NEAR(matched["scanners"][1]["boresight_used_deg"][1].get<double>(), 0.5, 0.1);
  const ProgramRun calibrate = RunProgram(
      {"calibrate", In("two_matched/flight.matched.yaml"), "--georef", "--out", In("two_result")});
  ASSERT_EQ(calibrate.exit_code, 0) << calibrate.err;
  ExpectNewStrips("two_result");
  const ProgramRun again = RunProgram(
      {"georef", In("two"), "--result", In("two_result/result.json"), "--out", In("two_clouds")});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  ExpectNewStrips("two_clouds");
  ExpectPageMatchesFiles(In("two_clouds"), 60);
  const ProgramRun angles =
      RunProgram({"georef", In("two"), "--boresight", "0,0,0", "--out", In("two_angles")});
  EXPECT_EQ(angles.exit_code, 2);
  EXPECT_THAT(angles.err, HasSubstr("--boresight takes one: add --scanner a"));
  const Json relative = Read("two_result/result.json")["relative_boresight"][0];
  const auto rotation = [](double roll_deg, double pitch_deg, double yaw_deg) {
    return Exp(Eigen::Vector3d(kRadPerDeg * Eigen::Vector3d(roll_deg, pitch_deg, yaw_deg)));
  };
  const Eigen::Vector3d truth_deg =
      kDegPerRad *
      Log(Eigen::Quaterniond(rotation(0.2, 0.03, 0.35).conjugate() * rotation(-0.4, 0.5, 0.1)));
  for (int i = 0; i < 3; ++i) {
    const double error_deg = relative["angles_deg"][i].get<double>() - truth_deg[i];
    EXPECT_LT(std::abs(error_deg), 4.0 * relative["sigma_deg"][i].get<double>());
  }
}

}  // namespace dn::testing::apps_test
