#include <dn/lidar/point_covariance.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "testing/random.h"

namespace dn::lidar_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Case {
  MapPose pose;
  Mounting mounting;
  Vector3d u_s;
  PointErrors errors;
};

Matrix3d RandomCovariance(std::mt19937& rng, double sigma) {
  Matrix3d A;
  for (int i = 0; i < 3; ++i) A.col(i) = testing::RandomVector(rng, sigma);
  return A * A.transpose() + 0.1 * sigma * sigma * Matrix3d::Identity();
}

Case RandomCase(std::mt19937& rng) {
  Case c;
  c.pose.q_mb = testing::RandomRotation(rng);
  c.pose.p_mb = testing::RandomVector(rng, 1000.0);
  c.mounting.R_bs_nominal = testing::RandomRotation(rng).toRotationMatrix();
  c.mounting.lever_arm_b_m = testing::RandomVector(rng, 1.0);
  c.mounting.boresight_rad = testing::RandomVector(rng, 0.05);
  c.u_s = 700.0 * testing::RandomVector(rng, 1.0);
  c.errors.position_m2 = RandomCovariance(rng, 0.03);
  c.errors.attitude_rad2 = RandomCovariance(rng, 5e-5);
  c.errors.boresight_rad2 = RandomCovariance(rng, 5e-5);
  c.errors.sigma_range_m = 0.02;
  c.errors.sigma_beam_rad = 1e-4;
  return c;
}

TEST(LaserVectorTo, IsTheInverseOfGeoreference) {
  std::mt19937 rng(3);
  for (int i = 0; i < 50; ++i) {
    const Case c = RandomCase(rng);
    const Vector3d p_m = Georeference(c.pose, c.mounting, c.u_s);
    EXPECT_LT((LaserVectorTo(c.pose, c.mounting, p_m) - c.u_s).norm(), 1e-9) << "seed 3, " << i;
  }
}

// Hand-computed values for a beam straight down from a level body.
TEST(PointCovariance, MatchesHandComputedNadirBeam) {
  Case c;
  c.u_s = Vector3d(0.0, 0.0, 1000.0);
  // 0.02 m and 0.01 m; yaw has no influence.
  c.errors.attitude_rad2 = Vector3d(4e-10, 1e-10, 9e-10).asDiagonal();
  c.errors.sigma_range_m = 0.03;
  c.errors.sigma_beam_rad = 2e-5;
  const Matrix3d C = PointCovariance(c.pose, c.mounting, c.u_s, c.errors);
  const Matrix3d expected = Vector3d(1e-4 + 4e-4, 4e-4 + 4e-4, 9e-4).asDiagonal();
  EXPECT_LT((C - expected).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(PointCovariance, AgreesWithManyDisturbedPoints) {
  constexpr int kDraws = 20000;
  // A variance from this many draws has a relative standard deviation of 1 %; the tolerance is five
  // times that.
  constexpr double kTolerance = 0.05;
  std::mt19937 rng(11);
  std::normal_distribution<double> normal;
  const auto draw = [&](const Matrix3d& C) -> Vector3d {
    const Vector3d e(normal(rng), normal(rng), normal(rng));
    return C.llt().matrixL() * e;
  };
  for (int trial = 0; trial < 3; ++trial) {
    SCOPED_TRACE("seed 11, trial " + std::to_string(trial));
    const Case c = RandomCase(rng);
    const Vector3d p_m = Georeference(c.pose, c.mounting, c.u_s);
    Matrix3d sum = Matrix3d::Zero();
    for (int i = 0; i < kDraws; ++i) {
      Case d = c;
      d.pose.p_mb += draw(c.errors.position_m2);
      d.pose.q_mb = c.pose.q_mb * Exp(draw(c.errors.attitude_rad2));
      const Eigen::Quaterniond boresight =
          Exp(draw(c.errors.boresight_rad2)) * Exp(c.mounting.boresight_rad);
      d.mounting.boresight_rad = Log(boresight);
      const Vector3d turn =
          c.errors.sigma_beam_rad * Vector3d(normal(rng), normal(rng), normal(rng));
      d.u_s = Exp(turn) * c.u_s;
      d.u_s *= 1.0 + c.errors.sigma_range_m * normal(rng) / c.u_s.norm();
      const Vector3d error_m = Georeference(d.pose, d.mounting, d.u_s) - p_m;
      sum += error_m * error_m.transpose() / kDraws;
    }
    const Matrix3d C = PointCovariance(c.pose, c.mounting, c.u_s, c.errors);
    EXPECT_LT((sum - C).norm(), kTolerance * C.norm());
  }
}

}  // namespace dn::lidar_test
