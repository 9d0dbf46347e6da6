#include <dn/error.h>
#include <dn/geo/median_step.h>
#include <dn/geo/trajectory.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "testing/expect_invalid.h"
#include "testing/random.h"

namespace dn::geo_test {

using testing::ExpectInvalid;

const LocalFrame kFrame({46.57 * kRadPerDeg, 6.52 * kRadPerDeg, 500.0});

// Rounding of coordinates as large as the Earth's radius.
constexpr double kPositionToleranceM = 5e-9;
constexpr double kAngleToleranceRad = 1e-14;

MapPose RandomPose(std::mt19937& rng) {
  MapPose pose;
  pose.t_s = 381000.0;
  pose.q_mb = testing::RandomRotation(rng);
  pose.p_mb = testing::RandomVector(rng, 2e4);
  pose.v_m = testing::RandomVector(rng, 60.0);
  return pose;
}

std::vector<NavPoint> TwoPoints() {
  std::vector<NavPoint> points(2);
  points[1].t_s = 1.0;
  return points;
}

TEST(NavPoint, RoundTripsThroughTheMap) {
  std::mt19937 rng(1);
  for (int i = 0; i < 50; ++i) {
    const MapPose pose = RandomPose(rng);
    const MapPose back = ToMapPose(ToNavPoint(pose, kFrame), kFrame);
    EXPECT_EQ(back.t_s, pose.t_s);
    EXPECT_LE((back.p_mb - pose.p_mb).norm(), kPositionToleranceM);
    EXPECT_LE((back.v_m - pose.v_m).norm(), 1e-12);
    // At small angles angularDistance is only accurate to the square root of the rounding error.
    EXPECT_LE(Log(Eigen::Quaterniond(back.q_mb.conjugate() * pose.q_mb)).norm(),
              kAngleToleranceRad);
  }
}

// A level aircraft is 20 km east of the origin with true heading north. Its attitude in m is the
// NED frame of the point, which differs by 0.18 deg from that of the origin.
TEST(NavPoint, AttitudeRefersToTheNorthEastDownOfThePoint) {
  MapPose pose;
  pose.p_mb = {20000.0, 0.0, 0.0};
  pose.q_mb = Eigen::Quaterniond(kFrame.R_mn(pose.p_mb));
  const NavPoint point = ToNavPoint(pose, kFrame);
  EXPECT_LE(RollPitchHeading(point.q_nb).norm(), kAngleToleranceRad);
  const Eigen::Quaterniond q_of_origin(kFrame.R_mn(Eigen::Vector3d::Zero()));
  EXPECT_GT(q_of_origin.angularDistance(pose.q_mb) * kDegPerRad, 0.18);
}

TEST(NavPoint, VelocityIsNorthEastDown) {
  MapPose pose;
  pose.v_m = {2.0, 3.0, 4.0};
  EXPECT_LE((ToNavPoint(pose, kFrame).v_ned_mps - Eigen::Vector3d(3.0, 2.0, -4.0)).norm(), 1e-14);
}

TEST(Trajectory, KnowsItsSpan) {
  const Trajectory trajectory(TwoPoints());
  EXPECT_EQ(trajectory.t_begin_s(), 0.0);
  EXPECT_EQ(trajectory.t_end_s(), 1.0);
  EXPECT_TRUE(trajectory.Covers(0.0) && trajectory.Covers(1.0));
  EXPECT_FALSE(trajectory.Covers(-0.001) || trajectory.Covers(1.001));
  EXPECT_FALSE(Trajectory().Covers(0.0));
  EXPECT_EQ(trajectory.ToMapPoses(kFrame).size(), 2u);
}

TEST(Trajectory, PointFromATimeIsTheNextOne) {
  const Trajectory trajectory(TwoPoints());
  EXPECT_EQ(trajectory.FirstPointAtOrAfter(-1.0).t_s, 0.0);
  EXPECT_EQ(trajectory.FirstPointAtOrAfter(0.0).t_s, 0.0);
  EXPECT_EQ(trajectory.FirstPointAtOrAfter(0.1).t_s, 1.0);
  EXPECT_EQ(trajectory.FirstPointAtOrAfter(3.0).t_s, 1.0);
}

TEST(MedianStep, IsNotThatOfAGap) {
  std::vector<NavPoint> points(4);
  const double t_s[] = {0.0, 0.5, 1.0, 61.0};
  for (std::size_t i = 0; i < points.size(); ++i) points[i].t_s = t_s[i];
  EXPECT_EQ(MedianStep(points), 0.5);
}

TEST(Trajectory, RejectsWhatIsNoTrajectory) {
  ExpectInvalid([] { Trajectory({NavPoint{}}); }, "has 1 points", 0);
  std::vector<NavPoint> points = TwoPoints();
  points[1].t_s = 0.0;
  ExpectInvalid([&] { Trajectory{points}; }, "point 1 at 0 s is not later", 0);
  for (int field = 0; field < 4; ++field) {
    points = TwoPoints();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    if (field == 0) points[1].position.h_m = nan;
    if (field == 1) points[1].q_nb.x() = nan;
    if (field == 2) points[1].v_ned_mps.z() = nan;
    if (field == 3) points[1].t_s = nan;
    ExpectInvalid([&] { Trajectory{points}; }, "point 1 is not finite", 0);
  }
}

// A cubic path with a constant turn rate is reproduced exactly.
TEST(InterpolatePose, IsExactOnACubicWithConstantTurn) {
  const Eigen::Vector3d a(1, 2, 3), b(4, -5, 6), c(0.7, 0.8, -0.9), d(0.1, -0.2, 0.3);
  const Eigen::Vector3d w(0.3, -0.2, 0.5);
  const auto exact = [&](double t) {
    MapPose pose;
    pose.t_s = t;
    pose.q_mb = Exp(Eigen::Vector3d(w * t));
    pose.p_mb = a + b * t + c * t * t + d * t * t * t;
    pose.v_m = b + 2 * c * t + 3 * d * t * t;
    return pose;
  };
  std::vector<MapPose> poses;
  for (const double t : {0.0, 0.7, 1.0, 2.5}) poses.push_back(exact(t));
  poses[1].q_mb.coeffs() *= -1.0;  // the sign of a quaternion does not matter
  for (const double t : {0.0, 0.3, 0.7, 0.9, 1.8, 2.5}) {
    SCOPED_TRACE(t);
    const MapPose pose = InterpolatePose(poses, t), expected = exact(t);
    EXPECT_EQ(pose.t_s, t);
    EXPECT_LE((pose.p_mb - expected.p_mb).norm(), 1e-13);
    EXPECT_LE((pose.v_m - expected.v_m).norm(), 1e-13);
    EXPECT_LE(Log(Eigen::Quaterniond(pose.q_mb.conjugate() * expected.q_mb)).norm(), 1e-14);
  }
}

TEST(Trajectory, InMapAtATimeIsThatOfAllItsPoints) {
  std::mt19937 rng(7);
  std::vector<NavPoint> points;
  for (const double t_s : {0.0, 0.7, 1.0, 2.5}) {
    MapPose pose = RandomPose(rng);
    pose.t_s = t_s;
    points.push_back(ToNavPoint(pose, kFrame));
  }
  const Trajectory trajectory(points);
  const std::vector<MapPose> poses = trajectory.ToMapPoses(kFrame);
  for (const double t_s : {0.0, 0.3, 0.7, 0.9, 1.8, 2.5}) {
    SCOPED_TRACE(t_s);
    const MapPose at = trajectory.MapPoseAt(t_s, kFrame), of_all = InterpolatePose(poses, t_s);
    EXPECT_EQ(at.t_s, of_all.t_s);
    EXPECT_EQ(at.p_mb, of_all.p_mb);
    EXPECT_EQ(at.v_m, of_all.v_m);
    EXPECT_EQ(at.q_mb.coeffs(), of_all.q_mb.coeffs());
  }
  for (const double t_s : {-0.1, 2.6, std::nan("")}) {
    ExpectInvalid([&] { trajectory.MapPoseAt(t_s, kFrame); },
                  "outside the trajectory (0 s to 2.5 s)", 0);
  }
}

TEST(InterpolatePose, RejectsTimesOutside) {
  std::vector<MapPose> poses(2);
  poses[1].t_s = 1.0;
  ExpectInvalid([&] { InterpolatePose(poses, 1.5); },
                "1.5 s is outside the trajectory (0 s to 1 s)", 0);
  ExpectInvalid([&] { InterpolatePose(poses, -0.5); }, "outside", 0);
  ExpectInvalid([&] { InterpolatePose(poses, std::nan("")); }, "outside", 0);
  ExpectInvalid([] { InterpolatePose({}, 0.0); }, "empty", 0);
}

}  // namespace dn::geo_test
