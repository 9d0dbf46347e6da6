#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>

#include "geo/angle_between.h"
#include "geo/moving_points.h"
#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::geo_test {

using testing::AngleRad;
using testing::ExpectInvalid;
using testing::MovingPoints;
using testing::TempFile;

constexpr std::size_t kRecordBytes = 136;

double Get(const std::string& sbet, std::size_t record, std::size_t column) {
  double value;
  std::memcpy(&value, sbet.data() + record * kRecordBytes + 8 * column, 8);
  return value;
}

void Set(std::string& sbet, std::size_t record, std::size_t column, double value) {
  std::memcpy(sbet.data() + record * kRecordBytes + 8 * column, &value, 8);
}

Trajectory ReadBinary(const std::string& sbet, bool body_is_flu = false) {
  const TempFile file("trajectory.out", sbet);
  return ReadTrajectory(file.path(), {.body_is_flu = body_is_flu});
}

void ExpectSamePoints(const Trajectory& trajectory, const std::vector<NavPoint>& points) {
  ASSERT_EQ(trajectory.points().size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const NavPoint &a = trajectory.points()[i], &b = points[i];
    EXPECT_EQ(a.t_s, b.t_s);
    EXPECT_EQ(a.position.lat_rad, b.position.lat_rad);
    EXPECT_EQ(a.position.lon_rad, b.position.lon_rad);
    EXPECT_EQ(a.position.h_m, b.position.h_m);
    EXPECT_LE(AngleRad(a.q_nb, b.q_nb), 1e-14);
    EXPECT_LE((a.v_ned_mps - b.v_ned_mps).norm(), 1e-13);
    EXPECT_EQ(a.f_b_mps2, b.f_b_mps2);
    EXPECT_EQ(a.w_b_radps, b.w_b_radps);
  }
}

TEST(Sbet, RoundTrips) {
  const std::vector<NavPoint> points = MovingPoints(500, 0.01);
  const std::string sbet = FormatSbet(points);
  ASSERT_EQ(sbet.size(), 500 * kRecordBytes);
  const Trajectory trajectory = ReadBinary(sbet);
  EXPECT_TRUE(trajectory.notes().velocity_from_file) << trajectory.notes().text;
  ExpectSamePoints(trajectory, points);
}

TEST(Sbet, IsForwardRightDownInAnyFlight) {
  const std::vector<NavPoint> points = MovingPoints(300, 0.01);
  ExpectSamePoints(ReadBinary(FormatSbet(points), true), points);
}

TEST(Sbet, WritesTheColumnsOfTheFormat) {
  const std::vector<NavPoint> points = MovingPoints(2, 1.0);
  const std::string sbet = FormatSbet(points);
  EXPECT_EQ(Get(sbet, 1, 0), 381001.0);
  EXPECT_EQ(Get(sbet, 1, 1), points[1].position.lat_rad);
  EXPECT_EQ(Get(sbet, 1, 2), points[1].position.lon_rad);
  EXPECT_EQ(Get(sbet, 1, 3), points[1].position.h_m);
  EXPECT_EQ(Get(sbet, 1, 5), points[1].v_ned_mps.y());
  EXPECT_NEAR(Get(sbet, 1, 7), 0.25, 1e-14);
  EXPECT_NEAR(Get(sbet, 1, 8), 0.04, 1e-14);
  EXPECT_NEAR(Get(sbet, 1, 9), 0.50, 1e-14);
  EXPECT_EQ(Get(sbet, 1, 10), 0.0);
  EXPECT_EQ(Get(sbet, 1, 13), points[1].f_b_mps2.z());
  EXPECT_EQ(Get(sbet, 1, 16), points[1].w_b_radps.z());
}

/// Converts a file with wander angle 0 to another wander angle and sign convention.
std::string Wandered(std::string sbet, double wander_rad, double y_sign, double z_sign) {
  for (std::size_t i = 0; i < sbet.size() / kRecordBytes; ++i) {
    const double vn = Get(sbet, i, 4), ve = Get(sbet, i, 5), vd = Get(sbet, i, 6);
    const double speed = std::hypot(vn, ve), course = std::atan2(ve, vn) + wander_rad;
    Set(sbet, i, 4, speed * std::cos(course));
    Set(sbet, i, 5, y_sign * speed * std::sin(course));
    Set(sbet, i, 6, z_sign * vd);
    Set(sbet, i, 9, Get(sbet, i, 9) + wander_rad);
    Set(sbet, i, 10, wander_rad);
  }
  return sbet;
}

TEST(Sbet, FindsTheSignsOfTheWanderFrame) {
  const std::vector<NavPoint> points = MovingPoints(500, 0.01);
  for (const double y_sign : {1.0, -1.0}) {
    for (const double z_sign : {1.0, -1.0}) {
      const Trajectory trajectory = ReadBinary(Wandered(FormatSbet(points), 0.7, y_sign, z_sign));
      EXPECT_TRUE(trajectory.notes().velocity_from_file) << trajectory.notes().text;
      EXPECT_THAT(trajectory.notes().text, ::testing::HasSubstr(y_sign > 0 ? "y right" : "y left"));
      EXPECT_THAT(trajectory.notes().text, ::testing::HasSubstr(z_sign > 0 ? "z down" : "z up"));
      ExpectSamePoints(trajectory, points);
    }
  }
}

TEST(Sbet, DifferentiatesWhereTheVelocitiesContradictThePositions) {
  const std::vector<NavPoint> points = MovingPoints(500, 0.01);
  std::string sbet = FormatSbet(points);
  for (std::size_t i = 0; i < points.size(); ++i) {  // forward, left, up of the vehicle
    Set(sbet, i, 4, 50.0);
    Set(sbet, i, 5, 1.0);
    Set(sbet, i, 6, 2.0);
  }
  const Trajectory trajectory = ReadBinary(sbet);
  EXPECT_FALSE(trajectory.notes().velocity_from_file);
  EXPECT_THAT(trajectory.notes().text, ::testing::HasSubstr("differentiated positions"));
  // The parabola through three points is exact up to a jerk of 0.125 m/s^3 over 0.01 s and rounding
  // of nanometres over 0.01 s.
  constexpr double kDifferentiationMps = 2e-5;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LE((trajectory.points()[i].v_ned_mps - points[i].v_ned_mps).norm(), kDifferentiationMps);
  }
}

TEST(Sbet, AcceptsVelocitiesWithinATenthOfAMetrePerSecond) {
  const std::vector<NavPoint> points = MovingPoints(500, 0.01);
  for (const double error_mps : {0.09, 0.11}) {
    std::string sbet = FormatSbet(points);
    for (std::size_t i = 0; i < points.size(); ++i) Set(sbet, i, 4, Get(sbet, i, 4) + error_mps);
    EXPECT_EQ(ReadBinary(sbet).notes().velocity_from_file, error_mps < 0.1);
  }
}

TEST(Sbet, DropsRepeatsAndContinuesOverTheWeek) {
  const std::vector<NavPoint> points = MovingPoints(4, 0.5);
  std::string sbet = FormatSbet(points);
  sbet += sbet.substr(3 * kRecordBytes);  // repeats the last record
  for (std::size_t i = 0; i < 5; ++i) {
    const double t_s = 604799.0 + 0.5 * static_cast<double>(std::min<std::size_t>(i, 3));
    Set(sbet, i, 0, t_s >= 604800.0 ? t_s - 604800.0 : t_s);
  }
  const Trajectory trajectory = ReadBinary(sbet);
  EXPECT_EQ(trajectory.notes().repeated_rows_dropped, 1);
  ASSERT_EQ(trajectory.points().size(), 4u);
  EXPECT_EQ(trajectory.t_end_s(), 604800.5);
}

TEST(Sbet, APathIsOfEpochsApart) {
  const std::vector<NavPoint> points = MovingPoints(500, 0.01);
  std::string sbet = FormatSbet(points);
  sbet += sbet.substr(499 * kRecordBytes);  // repeats the last record
  const TempFile file("trajectory.out", sbet);
  const std::vector<NavPoint> path = ReadSbetThinned(file.path(), 0.5);
  ASSERT_EQ(path.size(), 10u);
  for (std::size_t k = 0; k < path.size(); ++k) {
    EXPECT_GE(path[k].t_s, points[0].t_s + 0.5 * static_cast<double>(k));
    const auto same = std::find_if(points.begin(), points.end(),
                                   [&](const NavPoint& point) { return point.t_s == path[k].t_s; });
    ASSERT_NE(same, points.end());
    EXPECT_EQ(path[k].position.lat_rad, same->position.lat_rad);
    EXPECT_EQ(path[k].position.h_m, same->position.h_m);
    EXPECT_LE(AngleRad(path[k].q_nb, same->q_nb), 1e-14);
  }
  EXPECT_EQ(ReadSbetThinned(file.path(), 0.0).size(), points.size());
  const TempFile cut("cut.out", sbet.substr(0, 500));
  ExpectInvalid([&] { ReadSbetThinned(cut.path(), 0.5); }, "truncated", 0);
  Set(sbet, 2, 1, 46.57);
  const TempFile in_degrees("degrees.out", sbet);
  ExpectInvalid([&] { ReadSbetThinned(in_degrees.path(), 0.5); }, "SBET record 3: latitude", 0);
}

TEST(Sbet, RejectsBadFilesEachByItsOwnMessage) {
  const std::string good = FormatSbet(MovingPoints(10, 0.1));
  const auto with = [&](std::size_t record, std::size_t column, double value) {
    std::string sbet = good;
    Set(sbet, record, column, value);
    return [sbet] { ReadBinary(sbet); };
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ExpectInvalid([] { ReadBinary(""); }, "no rows of numbers", 0);
  ExpectInvalid([&] { ReadBinary(good.substr(0, 500)); }, "truncated: record 4 has 92 of 136 bytes",
                0);
  ExpectInvalid([&] { ReadBinary(good.substr(0, kRecordBytes)); }, "only one epoch", 0);
  ExpectInvalid(with(4, 0, nan), "time of SBET record 5 is not finite", 0);
  ExpectInvalid(with(4, 9, nan), "heading of SBET record 5 is not finite", 0);
  ExpectInvalid(with(4, 16, std::numeric_limits<double>::infinity()), "rate z of SBET record 5", 0);
  ExpectInvalid(with(4, 0, 381000.25), "does not increase", 0);
  ExpectInvalid(with(4, 0, 381000.3), "SBET record 5 does not increase", 0);
  ExpectInvalid(with(2, 1, 46.57), "SBET record 3: latitude", 0);
  ExpectInvalid(with(2, 2, -7.0), "SBET record 3: longitude", 0);
  ExpectInvalid([] { ReadTrajectory("/no/such/sbet.out"); }, "does not exist", 0);
}

// The content decides, not the ending of the name.
TEST(Sbet, AnyEnding) {
  const std::string sbet = FormatSbet(MovingPoints(10, 0.1));
  const std::string text = FormatTrajectoryText(MovingPoints(10, 0.1));
  for (const char* name : {"a.out", "SBET_1.OUT", "a.SBET", "a.Sbet", "a.bin", "a.txt", "a"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(ReadTrajectory(TempFile(name, sbet).path()).points().size(), 10u);
    EXPECT_EQ(ReadTrajectory(TempFile(name, text).path()).points().size(), 10u);
  }
}

TEST(Sbet, RejectionNamesTheFile) {
  const TempFile file("trajectory.OUT", "x");
  try {
    ReadTrajectory(file.path());
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.where().file, file.path().string());
  }
}

// Course, heading and sign convention are those documented with the data. The course is 158.41 deg
// from positions and 158.39 deg from velocities, and the true heading 163.99 deg; y is to the left
// of x.
TEST(Sbet, ReadsARealFile) {
  const std::filesystem::path path = DN_SHARED_DATA_DIR "/data/leeward/sbet.out";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "real data absent: " << path;
  const Trajectory trajectory = ReadTrajectory(path);
  ASSERT_EQ(trajectory.points().size(), 200u);
  EXPECT_TRUE(trajectory.notes().velocity_from_file) << trajectory.notes().text;
  EXPECT_THAT(trajectory.notes().text, ::testing::HasSubstr("y left"));
  const NavPoint& point = trajectory.points()[100];
  constexpr double kStatedDigitsDeg = 0.02;
  const double course_deg = std::atan2(point.v_ned_mps.y(), point.v_ned_mps.x()) * kDegPerRad;
  EXPECT_NEAR(course_deg, 158.39, kStatedDigitsDeg);
  EXPECT_NEAR(RollPitchHeading(point.q_nb).z() * kDegPerRad, 163.99, 0.1);
  EXPECT_NEAR(point.position.h_m, 6992.0, 5.0);
}

TEST(Sbet, MarksWhatWasAdjustedWithLidar) {
  const std::vector<NavPoint> points = MovingPoints(300, 0.01);
  const Trajectory trajectory = ReadBinary(FormatSbet(points, true));
  EXPECT_TRUE(trajectory.notes().adjusted_with_lidar);
  ExpectSamePoints(trajectory, points);
  EXPECT_EQ(Get(FormatSbet(points, true), 7, 10), 0.0);
  EXPECT_FALSE(ReadBinary(FormatSbet(points)).notes().adjusted_with_lidar);
}

TEST(Sbet, TheLidarMarkSurvivesCuttingAndThinning) {
  const std::string sbet = FormatSbet(MovingPoints(300, 0.01), true);
  EXPECT_TRUE(
      ReadBinary(sbet.substr(50 * kRecordBytes, 100 * kRecordBytes)).notes().adjusted_with_lidar);
  std::string thinned;
  for (std::size_t i = 0; i < 300; i += 3) thinned += sbet.substr(i * kRecordBytes, kRecordBytes);
  EXPECT_TRUE(ReadBinary(thinned).notes().adjusted_with_lidar);
}

}  // namespace dn::geo_test
