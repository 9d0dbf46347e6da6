#include <dn/error.h>
#include <dn/geo/trajectory.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "geo/moving_points.h"
#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn {
namespace {

using testing::ExpectInvalid;
using testing::MovingPoints;
using testing::TempFile;

Trajectory Read(const std::string& text, bool body_is_flu = false) {
  const TempFile file("trajectory.txt", text);
  return ReadTrajectory(file.path(), body_is_flu);
}

double AngleRad(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return Log(Eigen::Quaterniond(a.conjugate() * b)).norm();
}

TEST(TrajectoryText, RoundTrips) {
  const std::vector<NavPoint> points = MovingPoints(200, 0.05);
  const Trajectory trajectory = Read(FormatTrajectoryText(points));
  ASSERT_EQ(trajectory.points().size(), points.size());
  constexpr double kRoundingRad = 4e-16;
  // Parabola through three points at the ends: h^2/3 of a jerk of 0.125 m/s^3.
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

// Nose up by 0.1 rad: forward-left-up and forward-right-down share the forward axis, hence the
// pitch; a level forward-left-up body is half a turn about it from the other.
TEST(TrajectoryText, TurnsForwardLeftUp) {
  const Eigen::Quaterniond q_n_frd = QuaternionFromRollPitchHeading({0.0, 0.1, 0.0});
  const Eigen::Matrix3d R_frd_flu = Eigen::Vector3d(1, -1, -1).asDiagonal();
  std::vector<NavPoint> points = MovingPoints(2, 1.0);
  for (NavPoint& p : points) p.q_nb = Eigen::Quaterniond(q_n_frd.toRotationMatrix() * R_frd_flu);
  const Trajectory trajectory = Read(FormatTrajectoryText(points), true);
  EXPECT_LE(AngleRad(trajectory.points()[0].q_nb, q_n_frd), 1e-15);
}

TEST(TrajectoryText, TakesUnnormalisedAndNegativeQuaternions) {
  const Trajectory t = Read("1, 46, 6, 500, -1.001, 0, 0, 0\n2, 46, 359, 500, 0, 0, 0, 0.995\n");
  EXPECT_LE(AngleRad(t.points()[0].q_nb, Eigen::Quaterniond::Identity()), 0.0);
  EXPECT_NEAR(t.points()[1].q_nb.norm(), 1.0, 1e-15);
}

TEST(TrajectoryText, DropsRepeatsAndContinuesOverTheWeek) {
  const Trajectory t =
      Read("604799.5 46 6 500 1 0 0 0\n604799.5 46 6 500 1 0 0 0\n0.5 46 6 500 1 0 0 0\n");
  EXPECT_EQ(t.notes().repeated_rows_dropped, 1);
  EXPECT_EQ(t.t_end_s(), 604800.5);
}

TEST(TrajectoryText, RejectsBadFilesEachByItsOwnMessage) {
  const std::string ok = "1 46 6 500 1 0 0 0\n";
  ExpectInvalid([&] { Read(ok + "2 46 6 500 0 0 0 0\n"); }, "zero norm", 2);
  ExpectInvalid([&] { Read(ok + "2 46 6 500 1 1 0 0\n"); }, "norm 1.41", 2);
  ExpectInvalid([&] { Read(ok + "2 46 6 500 nan 0 0 0\n"); }, "not a finite number", 2);
  ExpectInvalid([&] { Read(ok + "2 91 6 500 1 0 0 0\n"); }, "latitude is 91", 2);
  ExpectInvalid([&] { Read(ok + "2 46 361 500 1 0 0 0\n"); }, "longitude is 361", 2);
  ExpectInvalid([&] { Read(ok + "1 46 6 501 1 0 0 0\n"); }, "does not increase", 2);
  ExpectInvalid([&] { Read(ok + "0.5 46 6 500 1 0 0 0\n"); }, "does not increase", 2);
  ExpectInvalid([&] { Read(ok); }, "only one epoch", 0);
  ExpectInvalid([&] { Read("1 46 6 500 0.1 0.2 0.3\n"); }, "7 columns, must have 8", 1);
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
  // Half of the epochs move at a speed that the vehicle can have.
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

}  // namespace
}  // namespace dn
