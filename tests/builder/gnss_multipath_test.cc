#include <dn/builder/gnss_multipath.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "testing/random.h"

namespace dn::builder_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kRatioRounding = 1e-12;
const GnssProcess kByBank{{0.02, 0.03, 0.05}, 20.0, GnssErrorGrowth::kBank};

/// Returns the ratio of the sigmas at an attitude in a map whose axes are rotated from north, east,
/// down by q_mn.
double Ratio(const Vector3d& rph_deg, const Quaterniond& q_mn) {
  MapPose pose;
  pose.q_mb = q_mn * QuaternionFromRollPitchHeading(kDeg * rph_deg);
  const Vector3d up_m = q_mn * Vector3d(0.0, 0.0, -1.0);
  const Vector3d ratio = GnssProcessSigma(kByBank, pose, up_m).cwiseQuotient(kByBank.sigma_enu_m);
  EXPECT_NEAR(ratio.y(), ratio.x(), kRatioRounding);
  EXPECT_NEAR(ratio.z(), ratio.x(), kRatioRounding);
  return ratio.x();
}

TEST(GnssProcessSigma, IsProportionalToTheRollOnEitherSide) {
  const Quaterniond same = Quaterniond::Identity();
  EXPECT_NEAR(Ratio({0.0, 0.0, 0.0}, same), 0.0, kRatioRounding);
  EXPECT_NEAR(Ratio({30.0, 0.0, 0.0}, same), 1.0, kRatioRounding);
  EXPECT_NEAR(Ratio({-15.0, 0.0, 0.0}, same), 0.5, kRatioRounding);
  EXPECT_NEAR(Ratio({60.0, 0.0, 0.0}, same), 2.0, kRatioRounding);
  EXPECT_NEAR(Ratio({-170.0, 0.0, 0.0}, same), 17.0 / 3.0, kRatioRounding);
}

TEST(GnssProcessSigma, DependsOnTheRollOnly) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> one(-1.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector3d rph_deg(179.0 * one(rng), 85.0 * one(rng), 180.0 * one(rng));
    const Quaterniond q_mn = testing::RandomRotation(rng);
    EXPECT_NEAR(Ratio(rph_deg, q_mn), std::abs(rph_deg.x()) / 30.0, 1e-9) << rph_deg.transpose();
  }
}

TEST(GnssProcessSigma, IsConstantForAnErrorThatDoesNotGrow) {
  GnssProcess constant = kByBank;
  constant.growth = GnssErrorGrowth::kNone;
  MapPose pose;
  pose.q_mb = QuaternionFromRollPitchHeading(kDeg * Vector3d(40.0, 3.0, 2.0));
  EXPECT_EQ(GnssProcessSigma(constant, pose, Vector3d(0.0, 0.0, -1.0)), constant.sigma_enu_m);
}

}  // namespace dn::builder_test
