#include <dn/lidar/mounting_fit.h>
#include <dn/lidar/point_spacing.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace dn::testing {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Points of a scanner whose beams turn in one plane, over ground with this relief.
std::vector<PointAndVector> ScanPoints(const Matrix3d& R_bs, const Vector3d& a_b_m, double relief_m,
                                       double noise_m) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, noise_m);
  std::vector<PointAndVector> points;
  for (int k = 0; k < 2000; ++k) {
    const double angle_rad = 0.6 * std::sin(0.37 * k);
    const double range_m = (200.0 + relief_m * std::sin(0.01 * k)) / std::cos(angle_rad);
    const Vector3d u_s_m(range_m * std::cos(angle_rad), 0.0, range_m * std::sin(angle_rad));
    const Vector3d error_m(noise(random), noise(random), noise(random));
    points.push_back({R_bs * u_s_m + a_b_m + error_m, u_s_m});
  }
  return points;
}

Matrix3d Turned() {
  Matrix3d R_bs;
  R_bs << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return Exp(Vector3d(0.01, -0.02, 0.03)) * R_bs;
}

TEST(FitMounting, FindsRotationAndLeverArm) {
  const Vector3d a_b_m(0.3, -0.1, 0.2);
  const auto fit = FitMounting(ScanPoints(Turned(), a_b_m, 20.0, 0.01));
  ASSERT_TRUE(fit.has_value());
  const double turn_rad = Log(Eigen::Quaterniond(fit->R_bs * Turned().transpose())).norm();
  EXPECT_LT(turn_rad, 1e-4);
  EXPECT_NEAR(fit->rms_m, 0.01, 0.001);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(fit->lever_arm_b_m[i], a_b_m[i], 4.0 * fit->lever_arm_sigma_m[i]);
    EXPECT_LT(fit->lever_arm_sigma_m[i], 0.02);
  }
}

TEST(FitMounting, KnowsThatFlatGroundDoesNotShowTheLeverArmForward) {
  const auto fit = FitMounting(ScanPoints(Turned(), {0.3, -0.1, 0.2}, 0.0, 0.01));
  ASSERT_TRUE(fit.has_value());
  EXPECT_GT(fit->lever_arm_sigma_m.x(), 0.5);
  EXPECT_LT(fit->lever_arm_sigma_m.z(), 0.1);
  EXPECT_NEAR(fit->rms_m, 0.01, 0.001);
}

TEST(FitMounting, NeedsVectorsInAPlane) {
  std::vector<PointAndVector> line(100, {Vector3d(0, 0, 100), Vector3d(100, 0, 0)});
  EXPECT_FALSE(FitMounting(line).has_value());
  EXPECT_FALSE(FitMounting({}).has_value());
}

TEST(NearestAxes, RemovesSmallTurns) {
  Matrix3d R_bs;
  R_bs << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  EXPECT_EQ(NearestAxes(Turned()), R_bs);
  EXPECT_EQ(NearestAxes(Matrix3d(Exp(Vector3d(0.0, 0.0, 0.7)))), Matrix3d::Identity());
}

TEST(PointSpacing, IsTheRootOfThePointsArea) {
  std::vector<Vector3d> p_m;
  for (int x = 0; x < 200; ++x) {
    for (int y = 0; y < 200; ++y) p_m.emplace_back(0.5 * x, 0.5 * y, 0.0);
  }
  EXPECT_NEAR(*PointSpacing(p_m, 40000.0), 0.5, 0.02);
  EXPECT_NEAR(*PointSpacing(p_m, 160000.0), 0.25, 0.01);  // a sample of every fourth point
  EXPECT_FALSE(PointSpacing({}, 0.0).has_value());
  EXPECT_FALSE(PointSpacing({Vector3d::Zero(), Vector3d(500, 0, 0)}, 2.0).has_value());
}

}  // namespace
}  // namespace dn::testing
