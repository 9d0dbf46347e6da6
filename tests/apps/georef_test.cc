#include <dn/files/flight.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/strip_io.h>
#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "damaged_flight.h"
#include "load_json.h"
#include "page_numbers.h"
#include "strip_scenario.h"
#include "testing/las_bytes.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kPoints = 50;
constexpr double kGridM = 1e-4;

/// The short flight with point clouds of its first line, computed with the true boresight.
class FlightWithStrips : public DamagedFlight {
 public:
  FlightWithStrips() {
    fs::rename(path() / "reference.out", path() / "trajectory.out");
    FlightConfig config = ReadFlightConfig(path());
    truth_ = config.lidar->mounting;
    truth_.boresight_rad = Eigen::Vector3d(0.2, 0.03, 0.35) * kRadPerDeg;
    const Flight flight = ReadFlight(config, {.trajectory = true});
    poses_ = flight.trajectory->ToMapPoses(flight.frame);
    Write("strips/1.txt", Text());
    Write("strips/2.las", Las(config.lidar->mounting));
  }

  static double Epoch(int i) { return 381250.0 + 0.3 * i; }
  static Eigen::Vector3d Beam(int i) { return {200.0, 0.5, 90.0 * std::sin(i)}; }
  Eigen::Vector3d Truth(int i) const {
    return Georeference(InterpolatePose(poses_, Epoch(i)), truth_, Beam(i));
  }

 private:
  std::string Text() const {
    std::string text;
    for (int i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d u_s = Beam(i);
      text += FormatDouble(Epoch(i)) + ", 0, 0, 0, " + FormatDouble(u_s.x()) + ", " +
              FormatDouble(u_s.y()) + ", " + FormatDouble(u_s.z()) + "\n";
    }
    return text;
  }

  /// Returns a LAS file computed with the assumed mounting.
  std::string Las(const Mounting& assumed) const {
    LasBytes las;
    las.scale = kGridM;
    for (int i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d p_m =
          Georeference(InterpolatePose(poses_, Epoch(i)), assumed, Beam(i)) / kGridM;
      las.points.push_back({static_cast<std::int32_t>(std::lround(p_m.x())),
                            static_cast<std::int32_t>(std::lround(p_m.y())),
                            static_cast<std::int32_t>(std::lround(p_m.z())), Epoch(i), 5, 1, 1,
                            ""});
    }
    return las.Build();
  }

  Mounting truth_;
  std::vector<MapPose> poses_;
};

StripCloud ReadAll(const fs::path& file) {
  StripCloud points;
  EXPECT_TRUE(OpenStrip(file)->Next(&points));
  return points;
}

TEST(CliGeoref, TheBoresightPutsThePointsWhereTheyAre) {
  const FlightWithStrips flight;
  const ProgramRun run = flight.Run("georef", {"--boresight", "0.2,0.03,0.35"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* name : {"1.txt", "2.las"}) {
    const StripCloud points = ReadAll(flight.out() / "strips" / name);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(kPoints)) << name;
    for (int i = 0; i < kPoints; ++i) {
      EXPECT_LT((points.p_c[static_cast<std::size_t>(i)] - flight.Truth(i)).norm(), 3 * kGridM);
    }
  }
  EXPECT_THAT(NamesIn(flight.out()),
              ElementsAre("config.resolved.yaml", "georef.json", "report.html", "report.json",
                          "strips", "swaths.geojson", "swaths.json"));
  ExpectPageMatchesFiles(flight.out(), 14);
  const Json json = Json::parse(FileContent(flight.out() / "georef.json"));
  EXPECT_EQ(json["schema"], "dn.georef/1");
  EXPECT_NEAR(json["boresight_deg"][2], 0.35, 1e-12);
  EXPECT_EQ(json["boresight_before_deg"][2], 0.0);
  EXPECT_EQ(json["strips"][0]["laser_vectors"], "file");
  EXPECT_EQ(json["strips"][1]["laser_vectors"], "trajectory");
  EXPECT_EQ(json["strips"][1]["kept"], kPoints);
  EXPECT_GT(json["strips"][1]["shift_rms_m"], 0.5);
  const Json report = Json::parse(FileContent(flight.out() / "report.json"));
  EXPECT_EQ(report["counts"]["points kept"], 2 * kPoints);
  EXPECT_THAT(run.err, HasSubstr("dn georef: strip 2.las\n"));
}

TEST(CliGeoref, AResultBringsItsBoresightAndItsCovariance) {
  const FlightWithStrips flight;
  const std::string result = (CalibrateResult() / "result.json").string();
  const ProgramRun run = flight.Run("georef", {"--result", result, "--covariance"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(FileContent(flight.out() / "georef.json"));
  EXPECT_NEAR(json["boresight_deg"][0], 0.2, 0.05);
  EXPECT_EQ(json["covariance"]["boresight"], result);
  const StripCloud points = ReadAll(flight.out() / "strips/1.txt");
  ASSERT_FALSE(points.covariance_c_m2.empty());
  // The range alone contributes 0.02 m along the beam; all errors together stay below 1 m.
  EXPECT_GT(points.covariance_c_m2[0].trace(), 0.02 * 0.02);
  EXPECT_LT(points.covariance_c_m2[0].trace(), 1.0);
  EXPECT_EQ(ReadAll(flight.out() / "strips/2.las").record_bytes, 28u + 24u);
}

/// Returns the result of the short flight with another verdict.
std::string ResultWithVerdict(const DamagedFlight& flight, const std::string& verdict) {
  Json json = Json::parse(FileContent(CalibrateResult() / "result.json"));
  json["assessment"]["verdict"] = verdict;
  flight.Write("../" + verdict + ".json", json.dump());
  return (flight.path().parent_path() / (verdict + ".json")).string();
}

TEST(CliGeoref, AResultThatCannotBeReliedOnNeedsAnyway) {
  const FlightWithStrips flight;
  for (const char* verdict : {"contradicted", "not_observable"}) {
    const std::string result = ResultWithVerdict(flight, verdict);
    const ProgramRun run = flight.Run("georef", {"--result", result});
    EXPECT_EQ(run.exit_code, 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr(std::string("the result is ") + verdict));
    EXPECT_THAT(run.err, HasSubstr("add --anyway (" + result + ")"));
    EXPECT_FALSE(fs::exists(flight.out() / "strips"));
    const ProgramRun anyway = flight.Run("georef", {"--result", result, "--anyway"});
    EXPECT_EQ(anyway.exit_code, 0) << anyway.err;
    EXPECT_THAT(anyway.err, HasSubstr("used because of --anyway"));
    EXPECT_TRUE(fs::exists(flight.out() / "strips/1.txt"));
  }
}

TEST(CliGeoref, AnAbsorbedResultIsUsedWithANote) {
  const FlightWithStrips flight;
  const ProgramRun run = flight.Run("georef", {"--result", ResultWithVerdict(flight, "absorbed")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("the result is absorbed"));
}

TEST(CliGeoref, StripsWithoutVectorsNeedTheBoresightOfTheirPoints) {
  const FlightWithStrips flight;
  const std::string warning = "2.las has no laser vectors";
  EXPECT_THAT(flight.Run("georef").err, HasSubstr(warning));
  EXPECT_FALSE(OpenStrip(flight.out() / "strips/2.las")->boresight_rad());
  flight.Replace("flight.yaml", "  boresight_deg: [0, 0, 0]", "  boresight_deg: [1, 1, 1]");
  flight.Replace("flight.yaml", "georeferenced_with: ~",
                 "georeferenced_with: {boresight_deg: [0, 0, 0]}");
  const ProgramRun run = flight.Run("georef", {"--boresight", "0.2,0.03,0.35"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, Not(HasSubstr(warning)));
  const StripCloud points = ReadAll(flight.out() / "strips/2.las");
  for (int i = 0; i < kPoints; ++i) {
    EXPECT_LT((points.p_c[static_cast<std::size_t>(i)] - flight.Truth(i)).norm(), 3 * kGridM);
  }
  const auto recorded_rad = OpenStrip(flight.out() / "strips/2.las")->boresight_rad();
  ASSERT_TRUE(recorded_rad);
  EXPECT_NEAR(recorded_rad->z(), 0.35 * kRadPerDeg, 1e-12);
}

TEST(CliGeoref, AnotherTrajectoryMovesThePoints) {
  const FlightWithStrips flight;
  const std::string smoothed = (SmoothResult() / "trajectory.out").string();
  const ProgramRun run = flight.Run("georef", {"--trajectory", smoothed});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(FileContent(flight.out() / "georef.json"));
  EXPECT_EQ(json["trajectory"], smoothed);
  EXPECT_GT(json["strips"][1]["shift_rms_m"], 1e-4);
  EXPECT_LT(json["strips"][1]["shift_rms_m"], 0.3);
}

void ExpectFailure(const ProgramRun& run, int exit_code, const std::string& what) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  EXPECT_THAT(run.err, HasSubstr(what));
}

TEST(CliGeoref, StripsAreComparedOnFlatGround) {
  const TempFolder folder;
  const auto in = [&](const std::string& name) { return (folder.path() / name).string(); };
  folder.Write("town.yaml", StripScenario("kind: built_up, roughness_m: 0.03"));
  ASSERT_EQ(RunProgram({"simulate", in("town.yaml"), "--out", in("flight")}).exit_code, 0);
  const ProgramRun run =
      RunProgram({"georef", in("flight"), "--boresight", "0.2,0.03,0.35", "--trajectory",
                  in("flight/reference.out"), "--out", in("out")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("height differences of strips on flat ground"));
  const Json pair = LoadJson(in("out/georef.json"))["strip_differences"][0];
  EXPECT_EQ(pair["strips"], Json({"1", "2"}));
  EXPECT_GT(pair["after"]["cells"].get<int>(), 500);
  EXPECT_LT(pair["after"]["rms_m"].get<double>(), 0.05);
  EXPECT_GT(pair["before"]["rms_m"].get<double>(), 2.0 * pair["after"]["rms_m"].get<double>());
  EXPECT_LT(std::abs(pair["after"]["median_m"].get<double>()), 0.01);
  const Json& sample = pair["sample"];
  EXPECT_GT(sample["after_m"].size(), 200u);
  EXPECT_LE(sample["after_m"].size(), 500u);
  EXPECT_EQ(sample["before_m"].size(), sample["after_m"].size());
  EXPECT_EQ(std::filesystem::exists(in("out/differences/1-2.prj")),
            LoadJson(in("out/georef.json"))["strips_crs"].get<std::string>().starts_with("utm"));
  const std::string page = FileContent(in("out/report.html"));
  EXPECT_THAT(page, HasSubstr("Height differences on flat ground, before"));
  EXPECT_THAT(page, HasSubstr("Height differences on flat ground, after"));
  EXPECT_THAT(page, HasSubstr("georef.json#/strip_differences/0/before/separation/to_8_cm"));
  std::istringstream raster(FileContent(in("out/" + pair["raster"].get<std::string>())));
  std::string word;
  long columns = 0, rows = 0, numbers = 0, cells = 0;
  raster >> word >> columns >> word >> rows;
  for (int k = 0; k < 8; ++k) raster >> word;
  for (double value = 0.0; raster >> value; ++numbers) cells += value > -9999.0 ? 1 : 0;
  EXPECT_EQ(numbers, columns * rows);
  EXPECT_NEAR(cells, pair["after"]["cells"].get<double>(), 0.02 * numbers);
}

TEST(CliGeoref, WhatIsMissingIsNamed) {
  const FlightWithStrips flight;
  for (const char* angles : {"1,2", "1,2,3,4", "a,b,c", "nan,0,0", "0,0,181"}) {
    ExpectFailure(flight.Run("georef", {"--boresight", angles}), 2, "must be roll,pitch,yaw");
  }
  flight.Write("no.json", "{}");
  ExpectFailure(flight.Run("georef", {"--result", (flight.path() / "no.json").string()}), 1,
                "not a result of `dn calibrate`");
  fs::rename(flight.path() / "strips", flight.path() / "clouds");
  ExpectFailure(flight.Run("georef"), 1, "the flight has no strips");
  fs::rename(flight.path() / "clouds", flight.path() / "strips");
  fs::remove(flight.path() / "trajectory.out");
  ExpectFailure(flight.Run("georef"), 1, "the flight has no trajectory; make one with `dn smooth");
  EXPECT_EQ(NamesIn(flight.out()), std::vector<std::string>{"report.json"});
}

TEST(CliGeoref, OneBadStripLeavesNoResult) {
  const FlightWithStrips flight;
  std::string laz = flight.Read("strips/2.las");
  laz[104] = static_cast<char>(0x81);
  flight.Write("strips/3.laz", laz);
  ExpectFailure(flight.Run("georef"), 1, "the record that says how is missing");
  EXPECT_EQ(NamesIn(flight.out()), (std::vector<std::string>{"report.html", "report.json"}));
}

TEST(CliGeoref, StripsWithoutASystemAreNotForIt) {
  const FlightWithStrips flight;
  flight.Replace("flight.yaml", "strips_crs: \"map\"", "strips_crs: none");
  ExpectFailure(flight.Run("georef"), 2, "strips_crs is 'none'");
}

TEST(CliGeoref, TheAdjustedTrajectoryBesideAResultIsUsed) {
  const FlightWithStrips flight;
  const fs::path result = flight.path().parent_path() / "result";
  fs::create_directory(result);
  fs::copy_file(flight.path() / "trajectory.out", result / "trajectory.out");
  const auto trajectory = [&](const std::string& method) {
    Json json = Json::parse(FileContent(CalibrateResult() / "result.json"));
    json["method"] = method;
    flight.Write("../result/result.json", json.dump());
    const ProgramRun run = flight.Run("georef", {"--result", (result / "result.json").string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Json::parse(FileContent(flight.out() / "georef.json"))["trajectory"].get<std::string>();
  };
  EXPECT_EQ(trajectory("dn"), (result / "trajectory.out").string());
  EXPECT_THAT(trajectory("gh"), Not(HasSubstr("result")));
}

}  // namespace dn::testing::apps_test
