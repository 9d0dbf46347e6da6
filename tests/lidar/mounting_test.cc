#include <dn/error.h>
#include <dn/lidar/beam.h>
#include <dn/lidar/beam_errors.h>
#include <dn/lidar/mounting.h>
#include <dn/rotation.h>

#include <Eigen/Geometry>
#include <cmath>

#include "testing/expect_invalid.h"

namespace dn::lidar_test {

using testing::ExpectInvalid;

constexpr double kRoundOff = 1e-13;  // error of a few products of numbers of order 100

TEST(CheckedRotation, ReturnsAnExactRotationUnchanged) {
  Eigen::Matrix3d R;
  R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  EXPECT_EQ(CheckedRotation(R), R);
}

TEST(CheckedRotation, ReturnsTheNearestRotationOfATypedOneAndKeepsIt) {
  const Eigen::Matrix3d exact(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()));
  const Eigen::Matrix3d typed = (exact * 1e7).array().round() / 1e7;
  const Eigen::Matrix3d R = CheckedRotation(typed);
  EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), kRoundOff);
  EXPECT_LE((R - typed).cwiseAbs().maxCoeff(),
            1e-7);  // rounding error of both matrices, half a unit of the last digit each
  EXPECT_EQ(CheckedRotation(R), R);
}

TEST(CheckedRotation, RejectsOtherMatrices) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  ExpectInvalid([&] { CheckedRotation(1.00001 * I); }, "not a rotation", 0);
  ExpectInvalid([&] { CheckedRotation(-I); }, "reflection", 0);
  ExpectInvalid([&] { CheckedRotation(std::nan("") * I); }, "not finite", 0);
}

// Hand-computed values: the mounting takes s-x to b-y; a boresight of +90 deg in yaw takes b-y to
// -b-x.
TEST(LaserVectorInBody, ComposesMountingAndBoresight) {
  Mounting mounting;
  mounting.R_bs_nominal << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  mounting.boresight_rad = Eigen::Vector3d(0, 0, std::acos(0.0));
  const Eigen::Vector3d u_b = LaserVectorInBody(mounting, {100, 0, 7});
  EXPECT_LE((u_b - Eigen::Vector3d(-100, 0, 7)).norm(), kRoundOff);
}

// Hand-computed values: the heading is east (body x is map x, body z is down) and the point lies
// 100 m below the scanner.
TEST(BeamErrors, AreRemovedFromTheVectorsOfTheirBeam) {
  const BeamErrors errors{Eigen::Vector3d::UnitY(), {0.0, std::asin(0.6)}, {2.0, 5.0}};
  EXPECT_LE((errors.Remove({0, 0, 100}, 0) - Eigen::Vector3d(0, 0, 98)).norm(), kRoundOff);
  EXPECT_LE((errors.Remove({0, 0, 105}, 1) - Eigen::Vector3d(0, 60, 80)).norm(), 1e-13 * 105);
  EXPECT_THROW(errors.Remove({0, 0, 100}, 2), InvalidInput);
  EXPECT_THROW(errors.Remove({0, 0, 100}, kNoBeam), InvalidInput);
}

TEST(Georeference, PutsTheLaserVectorAtTheScannerNotAtTheBodyOrigin) {
  MapPose pose;
  pose.p_mb = Eigen::Vector3d(10, 20, 500);
  Eigen::Matrix3d R_mb;
  R_mb << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  pose.q_mb = Eigen::Quaterniond(R_mb);
  Mounting mounting;
  mounting.lever_arm_b_m = Eigen::Vector3d(0.5, 0.25, 2.0);
  const Eigen::Vector3d p_m = Georeference(pose, mounting, {0, 3, 100});
  EXPECT_LE((p_m - Eigen::Vector3d(10.5, 16.75, 398.0)).norm(), kRoundOff);
}

TEST(Georeference, KeepsRangesWhateverTheBoresight) {
  Mounting mounting;
  mounting.boresight_rad = Eigen::Vector3d(0.3, -2.0, 1.0);
  const Eigen::Vector3d u_s(30, -40, 120);
  EXPECT_NEAR(Georeference(MapPose{}, mounting, u_s).norm(), 130.0, kRoundOff);
}

}  // namespace dn::lidar_test
