#include <dn/files/control.h>
#include <dn/files/flight_config.h>

#include <random>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {
namespace {

using testing::ExpectInvalid;
using ::testing::HasSubstr;
using testing::TempFolder;

const Geodetic kOrigin{46.57 * kRadPerDeg, 6.52 * kRadPerDeg, 400.0};

/// A flight folder with control files.
class Control {
 public:
  explicit Control(const std::string& yaml = "lidar: {sigma_p_m: 0.02}\n") : yaml_(yaml) {}

  Control& Add(const std::string& name, const std::string& text) {
    folder_.Write("control/" + name, text);
    return *this;
  }
  FlightConfig Config() const { return ParseFlightConfig(yaml_, folder_.path()); }
  ControlData Read() const { return ReadControl(Config(), LocalFrame(kOrigin)); }
  /// Expects an error about `points.txt` at a line.
  void ExpectBad(const std::string& text, const std::string& what, long line) {
    Add("points.txt", text);
    ExpectInvalid([&] { Read(); }, what, line);
  }

 private:
  TempFolder folder_;
  std::string yaml_;
};

TEST(Control, AFlightWithoutTheFolderHasNone) {
  Control control;
  EXPECT_FALSE(HasControl(control.Config()));
  EXPECT_TRUE(HasControl(control.Add("a.txt", "P1 1 2 3 .01 .01 .02\n").Config()));
}

TEST(Control, RowsWithoutAHeaderFollowTheirNumberOfColumns) {
  Control control("lidar: {sigma_p_m: 0.02}\ncontrol: {sigma_enu_m: 0.03}\n");
  control.Add("a.txt", "# surveyed in May\nP1, 10, 20, 5\n")
      .Add("b.txt", "P2 11 21 6 0.01 0.02 0.03\n")
      .Add("c.txt", "P3;12;22;7;0.01;0.01;0.02;381000.5;1;2;700\n")
      .Add("d.txt", "R1 30 40 8 0 0.6 0.8 0.05\n")
      .Add("e.txt", "R2 31 41 9 0 0 1 0.02 2.5\n");
  const ControlData data = control.Read();
  ASSERT_EQ(data.points.size(), 5u);
  EXPECT_EQ(data.points[0].name, "P1");
  EXPECT_NEAR((data.points[0].p_m - Eigen::Vector3d(10, 20, 5)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((data.points[0].covariance_m2 - 9e-4 * Eigen::Matrix3d::Identity()).norm(), 0, 1e-9);
  EXPECT_NEAR(data.points[1].covariance_m2(1, 1), 4e-4, 1e-9);
  EXPECT_NEAR(data.points[1].covariance_m2(2, 2), 9e-4, 1e-9);
  ASSERT_EQ(data.points[2].returns.size(), 1u);
  EXPECT_EQ(data.points[2].returns[0].t_s, 381000.5);
  EXPECT_EQ(data.points[2].returns[0].u_s, Eigen::Vector3d(1, 2, 700));
  ASSERT_TRUE(data.points[3].plane && data.points[4].plane);
  EXPECT_NEAR((data.points[3].plane->normal_m - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(data.points[3].plane->sigma_m, 0.05, 1e-9);
  EXPECT_EQ(data.points[4].plane->extent_m, 2.5);
}

TEST(Control, AHeaderNamesTheColumnsInAnyOrderWithUnits) {
  for (const char* header :
       {"# H [m], Name, E [m], N [m], sigma_m, code", "height name easting northing sigma skip",
        "\"Elevation (m)\";Point;East;North;Sigma;Remark"}) {
    const char separator = std::string(header).find(',') != std::string::npos   ? ','
                           : std::string(header).find(';') != std::string::npos ? ';'
                                                                                : ' ';
    std::string row = "7 P1 12 22 0.02 x\n";
    for (char& c : row) {
      if (c == ' ') c = separator;
    }
    const ControlData data = Control().Add("a.txt", std::string(header) + "\n" + row).Read();
    ASSERT_EQ(data.points.size(), 1u) << header;
    EXPECT_EQ(data.points[0].name, "P1");
    EXPECT_NEAR((data.points[0].p_m - Eigen::Vector3d(12, 22, 7)).norm(), 0.0, 1e-9) << header;
    EXPECT_NEAR(data.points[0].covariance_m2(2, 2), 4e-4, 1e-9);
  }
}

TEST(Control, AColumnTellsCornersFromSurfaces) {
  const ControlData data = Control()
                               .Add("a.txt",
                                    "name e n h sigma shape\nA 1 2 3 .02 corner\n"
                                    "B 1 2 3 .02 Surface\nC 1 2 3 .02 -\n")
                               .Read();
  ASSERT_EQ(data.points.size(), 3u);
  EXPECT_TRUE(data.points[0].is_corner);
  EXPECT_FALSE(data.points[1].is_corner);
  EXPECT_FALSE(data.points[2].is_corner);
  for (const char* key : {"search_radius_m", "corner_radius_m"}) {
    const std::string yaml = "lidar: {sigma_p_m: 0.02}\ncontrol: {" + std::string(key) + ": 51}\n";
    ExpectInvalid([&] { Control(yaml).Config(); }, "must be at most 50 m", 2);
  }
  Control().ExpectBad("name e n h sigma shape\nA 1 2 3 .02 sphere\n",
                      "the shape is 'sphere', must be surface or corner", 2);
  Control().ExpectBad(
      "name e n h sigma shape normal_e normal_n normal_u\nA 1 2 3 .02 corner 0 0 1\n",
      "a row with a normal is a plane", 2);
}

TEST(Control, GeographicAndGridCoordinatesGiveTheSamePoint) {
  // 46.571 deg north, 6.521 deg east in the UTM zone 32, from GeographicLib's GeoConvert.
  const ControlData geographic =
      Control().Add("a.txt", "name lat lon h sigma\nP1 46.571 6.521 410 0.02\n").Read();
  const ControlData unnamed =
      Control("lidar: {sigma_p_m: 0.02}\ncontrol: {crs: geographic, sigma_enu_m: 0.02}\n")
          .Add("a.txt", "P1 46.571 6.521 410\n")
          .Read();
  const LocalFrame frame(kOrigin);
  const Eigen::Vector3d p_m = frame.ToMap({46.571 * kRadPerDeg, 6.521 * kRadPerDeg, 410.0});
  EXPECT_NEAR((geographic.points[0].p_m - p_m).norm(), 0.0, 1e-9);
  EXPECT_NEAR((unnamed.points[0].p_m - p_m).norm(), 0.0, 1e-9);
  const Eigen::Vector3d p_c = PointCrs("utm:32n", frame).FromMap(p_m);
  const std::string row =
      "P1 " + std::to_string(p_c.x()) + " " + std::to_string(p_c.y()) + " 410 0 0 1 0.01\n";
  const ControlData grid =
      Control("lidar: {sigma_p_m: 0.02}\nstrips_crs: utm:32n\n").Add("a.txt", row).Read();
  EXPECT_NEAR((grid.points[0].p_m - p_m).norm(), 0.0, 1e-5);
  EXPECT_NEAR((grid.points[0].plane->normal_m - frame.R_m_enu(p_m).col(2)).norm(), 0.0, 1e-5);
}

TEST(Control, ChecksAreNamedByColumnByFileOrByTheConfiguration) {
  Control control("lidar: {sigma_p_m: 0.02}\ncontrol: {sigma_enu_m: 0.02, checks: [P3]}\n");
  control.Add("a.txt", "name e n h role\nP1 1 2 3 check\nP2 4 5 6 observation\nP3 1 1 1 -\n")
      .Add("Checkpoints.txt", "C1 1 2 4\n");
  std::string checks;
  for (const ControlPoint& point : control.Read().points) {
    if (point.is_check) checks += point.name + " ";
  }
  EXPECT_EQ(checks, "C1 P1 P3 ");
}

TEST(Control, FurtherReturnsOfAPointRepeatItsCoordinates) {
  const ControlData data = Control()
                               .Add("a.txt",
                                    "P1 1 2 3 .01 .01 .01 100 0 0 9\n"
                                    "P1 1 2 3 .01 .01 .01 200 0 1 9\n")
                               .Read();
  ASSERT_EQ(data.points.size(), 1u);
  EXPECT_EQ(data.points[0].returns.size(), 2u);
  Control().ExpectBad("P1 1 2 3 .01 .01 .01\nP1 1 2 4 .01 .01 .01\n", "is given twice", 2);
}

TEST(Control, BadRowsAreNamedWithTheirLine) {
  Control control;
  control.ExpectBad("", "no points", 0);
  control.ExpectBad("# only a comment\n", "no points", 0);
  control.ExpectBad("P1 1 2 3 .01 .01 .01\nP2 1 x 3 .01 .01 .01\n", "'x' is not a number", 2);
  control.ExpectBad("P1 1 2 nan .01 .01 .01\n", "not a finite number", 1);
  control.ExpectBad("P1 1 2 3 .01 0 .01\n", "sigma is 0", 1);
  control.ExpectBad("P1 1 2 3 .01 -1 .01\n", "sigma is -1", 1);
  control.ExpectBad("P1 1 2 3\n", "has no sigma", 1);
  control.ExpectBad("P1 1 2 3 4\n", "row has 5 columns", 1);
  control.ExpectBad("P1 1 2 3 .01 .01 .01\nP2 1 2 3\n", "row has 4 columns", 2);
  control.ExpectBad("P1 1 2 3 0 0 0 .01\n", "normal has no length", 1);
  control.ExpectBad("P1 1 2 3 .01 .01 .01 100 0 0 0\n", "laser vector has a length of 0", 1);
  control.ExpectBad("P1 1 2 3 .01 .01 .01 -9e9 0 0 9\n", "", 1);
  control.ExpectBad("name e n h sigma colour\nP1 1 2 3 .01 red\n", "names no column", 1);
  control.ExpectBad("name e n sigma\nP1 1 2 .01\n", "no column 'height'", 1);
  control.ExpectBad("name e n h h\nP1 1 2 3 4\n", "'height' twice", 1);
  control.ExpectBad("name e n h t ux\nP1 1 2 3 4 5\n", "only some of the columns t, ux, uy, uz", 1);
  control.ExpectBad("name e n h sigma t ux uy uz\nP1 1 2 3 .1 7 - - -\n", "belong together", 2);
  control.ExpectBad("name e n h sigma role\nP1 1 2 3 .1 maybe\n", "must be observation or check",
                    2);
  control.ExpectBad("name lat lon h sigma\nP1 146 6 3 .1\n", "lat", 2);
}

TEST(Control, DamagedFilesAreReadOrRefusedButNothingElse) {
  const std::string whole =
      "name, east, north, height, sigma, t, ux, uy, uz, role\n"
      "P1, 1.5, 2.5, 3.5, 0.01, 100, 0, 0.5, 9, check\n"
      "P2, 4.5, 5.5, 6.5, 0.02, -, -, -, -, observation\n";
  std::mt19937 random(7);
  Control control;
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = whole;
    for (int changes = 0; changes < 3; ++changes) {
      text[random() % text.size()] = static_cast<char>(random() % 256);
    }
    if (i % 3 == 0) text.resize(random() % text.size());
    control.Add("points.txt", text);
    try {
      control.Read();
    } catch (const InvalidInput& error) {
      ++refused;
      EXPECT_NE(std::string(error.what()), "");
    }
  }
  EXPECT_GT(refused, 500);
}

TEST(Control, UnknownChecksAreNamed) {
  Control control("lidar: {sigma_p_m: 0.02}\ncontrol: {checks: [P9]}\n");
  control.ExpectBad("P1 1 2 3 .01 .01 .01\n", "'P9'", 0);
}

TEST(Control, PointsFarFromTheFlightNameTheirCoordinateSystem) {
  const LocalFrame frame(kOrigin);
  const std::vector<Eigen::Vector3d> flown_m{{0, 0, 700}, {5000, 0, 700}};
  const auto expect_near = [&](const Control& control, const std::string& crs) {
    ExpectControlNear(control.Read(), flown_m, frame, crs);
  };
  Control near, grid, swapped;
  near.Add("a.txt", "P1 1000 2 3 .01 .01 .02\n");
  EXPECT_NO_THROW(expect_near(near, "map"));
  grid.Add("a.txt", "P1 310000 5160000 3 .01 .01 .02\n");
  ExpectInvalid([&] { expect_near(grid, "map"); }, "control.crs", 1);
  swapped.Add("a.txt", "name lat lon h sigma\nP1 6.521 46.571 410 .02\n");
  ExpectInvalid([&] { expect_near(swapped, "geographic"); }, "are exchanged", 2);
}

}  // namespace
}  // namespace dn::files_test
