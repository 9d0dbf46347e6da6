#include <dn/error.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "geo/angle_between.h"
#include "geo/moving_points.h"
#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::geo_test {

using testing::AngleRad;
using testing::ExpectInvalid;
using testing::MovingPoints;
using testing::TempFile;

Trajectory ReadText(const std::string& text, bool body_is_flu = false) {
  const TempFile file("trajectory.txt", text);
  return ReadTrajectory(file.path(), {.body_is_flu = body_is_flu});
}

Trajectory ReadText(const std::string& text, const TrajectoryColumns& columns) {
  const TempFile file("trajectory.txt", text);
  return ReadTrajectory(file.path(), columns);
}

std::string Row(double t_s, const Eigen::Vector3d& position, const std::vector<double>& attitude) {
  std::string row = FormatDouble(t_s);
  for (const double x : position) row += ' ' + FormatDouble(x);
  for (const double x : attitude) row += ' ' + FormatDouble(x);
  return row + '\n';
}

TEST(TrajectoryText, RoundTrips) {
  const std::vector<NavPoint> points = MovingPoints(200, 0.05);
  const Trajectory trajectory = ReadText(FormatTrajectoryText(points));
  ASSERT_EQ(trajectory.points().size(), points.size());
  constexpr double kRoundingRad = 4e-16;
  // The parabola through three points has, at the ends, an error of h^2/3 times a jerk of 0.125
  // m/s^3.
  constexpr double kDifferentiationMps = 1.1e-4;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const NavPoint &a = trajectory.points()[i], &b = points[i];
    EXPECT_EQ(a.t_s, b.t_s);
    EXPECT_NEAR(a.position.lat_rad, b.position.lat_rad, kRoundingRad);
    EXPECT_NEAR(a.position.lon_rad, b.position.lon_rad, kRoundingRad);
    EXPECT_EQ(a.position.h_m, b.position.h_m);
    EXPECT_LE(AngleRad(a.q_nb, b.q_nb), 1e-15);
    EXPECT_LE((a.v_ned_mps - b.v_ned_mps).norm(), kDifferentiationMps);
  }
  EXPECT_FALSE(trajectory.notes().velocity_from_file);
}

// Nose up by 0.1 rad. Forward-left-up and forward-right-down frames share the forward axis and
// therefore the pitch; they differ by half a turn about it.
TEST(TrajectoryText, TurnsForwardLeftUp) {
  const Eigen::Quaterniond q_n_frd = QuaternionFromRollPitchHeading({0.0, 0.1, 0.0});
  const Eigen::Matrix3d R_frd_flu = Eigen::Vector3d(1, -1, -1).asDiagonal();
  std::vector<NavPoint> points = MovingPoints(2, 1.0);
  for (NavPoint& p : points) p.q_nb = Eigen::Quaterniond(q_n_frd.toRotationMatrix() * R_frd_flu);
  const Trajectory trajectory = ReadText(FormatTrajectoryText(points), true);
  EXPECT_LE(AngleRad(trajectory.points()[0].q_nb, q_n_frd), 1e-15);
}

TEST(TrajectoryText, TakesUnnormalisedAndNegativeQuaternions) {
  const Trajectory t =
      ReadText("1, 46, 6, 500, -1.001, 0, 0, 0\n2, 46, 359, 500, 0, 0, 0, 0.995\n");
  EXPECT_LE(AngleRad(t.points()[0].q_nb, Eigen::Quaterniond::Identity()), 0.0);
  EXPECT_NEAR(t.points()[1].q_nb.norm(), 1.0, 1e-15);
}

TEST(TrajectoryText, DropsRepeatsAndContinuesOverTheWeek) {
  const Trajectory t =
      ReadText("604799.5 46 6 500 1 0 0 0\n604799.5 46 6 500 1 0 0 0\n0.5 46 6 500 1 0 0 0\n");
  EXPECT_EQ(t.notes().repeated_rows_dropped, 1);
  EXPECT_EQ(t.t_end_s(), 604800.5);
}

TEST(TrajectoryText, RejectsBadFilesEachByItsOwnMessage) {
  const std::string ok = "1 46 6 500 1 0 0 0\n";
  ExpectInvalid([&] { ReadText(ok + "2 46 6 500 0 0 0 0\n"); }, "zero norm", 2);
  ExpectInvalid([&] { ReadText(ok + "2 46 6 500 1 1 0 0\n"); }, "norm 1.41", 2);
  ExpectInvalid([&] { ReadText(ok + "2 46 6 500 nan 0 0 0\n"); }, "not a finite number", 2);
  ExpectInvalid([&] { ReadText(ok + "2 91 6 500 1 0 0 0\n"); }, "latitude is 91", 2);
  ExpectInvalid([&] { ReadText(ok + "2 46 361 500 1 0 0 0\n"); }, "longitude is 361", 2);
  ExpectInvalid([&] { ReadText(ok + "1 46 6 501 1 0 0 0\n"); }, "does not increase", 2);
  ExpectInvalid([&] { ReadText(ok + "0.5 46 6 500 1 0 0 0\n"); }, "does not increase", 2);
  ExpectInvalid([&] { ReadText(ok); }, "only one epoch", 0);
  ExpectInvalid([&] { ReadText("1 46 6 500 0.1 0.2 0.3\n"); }, "7 columns, must have 8", 1);
}

using Attitude = TrajectoryColumns::Attitude;

// Writes the same points in every coordinate system.
TEST(TrajectoryText, ReadsProjectedLocalAndGeocentricPositions) {
  const std::vector<NavPoint> points = MovingPoints(20, 1.0);
  const Geodetic origin{points[0].position.lat_rad - 0.001, points[0].position.lon_rad, 300.0};
  const LocalFrame frame(origin);
  for (const char* crs : {"map", "utm:32n", "ecef"}) {
    const PointCrs points_crs(crs, frame);
    std::string text;
    for (const NavPoint& p : points) {
      text += Row(p.t_s, points_crs.FromMap(frame.ToMap(p.position)),
                  {p.q_nb.w(), p.q_nb.x(), p.q_nb.y(), p.q_nb.z()});
    }
    const Trajectory trajectory = ReadText(text, {.crs = crs, .map_origin = origin});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const NavPoint& read = trajectory.points()[i];
      EXPECT_LE((frame.ToMap(read.position) - frame.ToMap(points[i].position)).norm(), 1e-7) << crs;
      EXPECT_LE(AngleRad(read.q_nb, points[i].q_nb), 1e-14) << crs;
    }
  }
}

// A body with heading 30 deg, nose up 10 deg and right wing down 5 deg. The test spells out the
// signs of its axes forward, right, down in north, east, down.
TEST(TrajectoryText, ReadsAttitudesOfOtherConventions) {
  const Eigen::Vector3d rph_deg(5.0, 10.0, 30.0);
  const Eigen::Quaterniond q_n_frd = QuaternionFromRollPitchHeading(kRadPerDeg * rph_deg);
  const Eigen::Matrix3d R_n_frd = q_n_frd.toRotationMatrix();
  EXPECT_GT(R_n_frd(0, 0), 0.8);   // forward points north
  EXPECT_LT(R_n_frd(2, 0), -0.1);  // and up
  EXPECT_GT(R_n_frd(2, 1), 0.05);  // right points down
  Eigen::Matrix3d R_enu_ned;
  R_enu_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const Eigen::Matrix3d R_frd_flu = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Quaterniond q_enu_frd(R_enu_ned * R_n_frd);
  const Eigen::Quaterniond q_enu_flu(R_enu_ned * R_n_frd * R_frd_flu);
  const auto expect = [&](const std::vector<double>& attitude, const TrajectoryColumns& columns) {
    const Eigen::Vector3d p(46.0, 6.0, 500.0);
    const Trajectory t = ReadText(Row(1.0, p, attitude) + Row(2.0, p, attitude), columns);
    EXPECT_LE(AngleRad(t.points()[0].q_nb, q_n_frd), 1e-14);
  };
  const auto wxyz = [](const Eigen::Quaterniond& q) {
    return std::vector<double>{q.w(), q.x(), q.y(), q.z()};
  };
  expect(wxyz(q_enu_frd), {.attitude = Attitude::kQuaternionEnu});
  expect(wxyz(q_enu_flu), {.attitude = Attitude::kQuaternionEnu, .body_is_flu = true});
  expect({5.0, 10.0, 30.0}, {.attitude = Attitude::kRollPitchHeading});
  // Nose up is a negative rotation about the left axis, and yaw counts from east, opposite to
  // heading.
  expect({5.0, -10.0, 60.0}, {.attitude = Attitude::kRollPitchYawEnu});
}

// Meridian convergence is approximately the difference of longitude times the sine of the latitude.
TEST(TrajectoryText, TurnsGridNorth) {
  const LocalFrame frame({46.0 * kRadPerDeg, 6.0 * kRadPerDeg, 500.0});
  const Eigen::Vector3d p_utm = PointCrs("utm:32n", frame).FromMap(Eigen::Vector3d::Zero());
  const TrajectoryColumns columns{
      .crs = "utm:32n", .attitude = Attitude::kRollPitchHeading, .grid_north = true};
  const Trajectory t =
      ReadText(Row(1.0, p_utm, {0.0, 0.0, 30.0}) + Row(2.0, p_utm, {0.0, 0.0, 30.0}), columns);
  const double heading_deg = kDegPerRad * RollPitchHeading(t.points()[0].q_nb).z();
  const double convergence_deg = (6.0 - 9.0) * std::sin(46.0 * kRadPerDeg);
  EXPECT_NEAR(heading_deg, 30.0 + convergence_deg, 0.002);
}

TEST(TrajectoryText, ErrorsOfOtherColumnsSayWhatIsWrong) {
  const TrajectoryColumns angles{.attitude = Attitude::kRollPitchHeading};
  ExpectInvalid([&] { ReadText("1 46 6 500 1 0 0 0\n", angles); }, "8 columns, must have 7", 1);
  ExpectInvalid([&] { ReadText("1 46 6 500 0 91 0\n2 46 6 500 0 9 0\n", angles); },
                "must be within 180, 90", 1);
  ExpectInvalid([&] { ReadText("1 46 6 500 1 0 0 0\n2 46 6 5 1 0 0 0\n", {.crs = "utm:32n"}); },
                "if these are degrees, set trajectory.crs: geographic", 1);
  EXPECT_THROW(ReadText("1 0 0 500 1 0 0 0\n2 1 0 500 1 0 0 0\n", {.crs = "map"}), InvalidConfig);
}

struct RealFile {
  const char* name;
  std::size_t rows;
  double max_speed_mps;
};

class RealTrajectory : public ::testing::TestWithParam<RealFile> {};

TEST_P(RealTrajectory, Reads) {
  const std::filesystem::path path =
      std::filesystem::path(DN_SHARED_DATA_DIR "/data") / GetParam().name;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "real data absent: " << path;
  const Trajectory trajectory = ReadTrajectory(path);
  EXPECT_EQ(trajectory.points().size() +
                static_cast<std::size_t>(trajectory.notes().repeated_rows_dropped),
            GetParam().rows);
  for (const NavPoint& point : trajectory.points()) {
    EXPECT_NEAR(point.q_nb.norm(), 1.0, 1e-15);
  }
  // Half of the epochs must have a plausible speed for the vehicle.
  std::vector<double> speeds_mps;
  for (const NavPoint& point : trajectory.points()) speeds_mps.push_back(point.v_ned_mps.norm());
  std::nth_element(speeds_mps.begin(), speeds_mps.begin() + speeds_mps.size() / 2,
                   speeds_mps.end());
  EXPECT_LT(speeds_mps[speeds_mps.size() / 2], GetParam().max_speed_mps);
  EXPECT_GT(speeds_mps[speeds_mps.size() / 2], 0.1);
}

INSTANTIATE_TEST_SUITE_P(Shared, RealTrajectory,
                         ::testing::Values(RealFile{"thor75/reference.txt", 33573, 30.0},
                                           RealFile{"psins-car/reference.txt", 1000, 40.0},
                                           RealFile{"tent/trajectory.txt", 1983, 30.0}),
                         [](const auto& param_info) {
                           std::string name = param_info.param.name;
                           name = name.substr(0, name.find('/'));
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace dn::geo_test
