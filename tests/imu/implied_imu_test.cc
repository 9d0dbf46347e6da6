#include <dn/imu/implied_imu.h>
#include <dn/imu/strapdown.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <vector>

#include "testing/earth_motion.h"
#include "testing/expect_invalid.h"

namespace dn::imu_test {

using testing::EarthMotion;
using testing::PlaneMotion;

constexpr double kRateHz = 100.0, kLengthS = 20.0;

std::vector<MapPose> Poses(const EarthMotion& motion, double t0_s) {
  std::vector<MapPose> poses;
  const int n = static_cast<int>(kLengthS * kRateHz);
  for (int k = 0; k <= n; ++k) poses.push_back(motion.Pose(t0_s + k / kRateHz));
  return poses;
}

// The reference data come from the same motion by the Coriolis form, Euler angles and quadrature.
TEST(ImpliedImu, AgreesWithAPerfectSensor) {
  const EarthMotion motion = PlaneMotion();
  const ImuData measured = motion.Measure(0.0, kLengthS, kRateHz);
  const ImuData implied = ImpliedImu(motion.frame, Poses(motion, 0.0), kRateHz);
  ASSERT_EQ(implied.samples.size(), measured.samples.size());
  double gyro = 0.0, accel = 0.0;
  for (std::size_t k = 0; k < measured.samples.size(); ++k) {
    const ImuSample &a = implied.samples[k], &b = measured.samples[k];
    EXPECT_NEAR(a.t_s, b.t_s, 1e-9);
    EXPECT_NEAR(a.dt_s, b.dt_s, 1e-9);
    gyro = std::max(gyro, (a.w_ib_b_radps - b.w_ib_b_radps).norm());
    accel = std::max(accel, (a.f_b_mps2 - b.f_b_mps2).norm());
  }
  EXPECT_LT(gyro, 1e-6) << "of 0.5 rad/s; an Earth rate is 7e-5";
  EXPECT_LT(accel, 1e-4) << "of 10 m/s^2; a Coriolis term is 9e-3";
}

TEST(ImpliedImu, LeadsFromTheFirstPoseToTheLast) {
  const EarthMotion motion = PlaneMotion();
  const std::vector<MapPose> poses = Poses(motion, 300.0);
  const ImuData imu = ImpliedImu(motion.frame, poses, kRateHz);
  MapPose pose = poses.front();
  for (int s = 1; s <= static_cast<int>(kLengthS); ++s) {
    pose = Propagate(motion.frame, pose, Preintegrate(imu, pose.t_s, 300.0 + s, {}, {}));
  }
  EXPECT_LT((pose.p_mb - poses.back().p_mb).norm(), 1e-3);
  EXPECT_LT((pose.v_m - poses.back().v_m).norm(), 1e-4);
  EXPECT_LT(pose.q_mb.angularDistance(poses.back().q_mb), 5e-6) << "coning of single samples";
}

TEST(ImpliedImu, TooShortAMotionIsNamed) {
  const EarthMotion motion = PlaneMotion();
  testing::ExpectInvalid([&] { ImpliedImu(motion.frame, {}, kRateHz); }, "too short for a sample",
                         0);
  testing::ExpectInvalid([&] { ImpliedImu(motion.frame, Poses(motion, 0.0), 0.0); }, "0.0", 0);
}

}  // namespace dn::imu_test
