#include <dn/imu/preintegration.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "testing/earth_motion.h"

namespace dn {
namespace {

using Eigen::Vector3d;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

// Rough sensors, so that every term of the covariance counts.
const PreintegrationNoise kNoise{2e-3, 5e-3, 0.0};

Vector9 Difference(const Preintegrated& noisy, const Preintegrated& clean) {
  Vector9 d;
  d << Log(Eigen::Quaterniond(clean.delta_q.conjugate() * noisy.delta_q)),
      noisy.delta_v - clean.delta_v, noisy.delta_p - clean.delta_p;
  return d;
}

/// Relative to the standard deviations, so that every entry counts alike.
Matrix9 Normalised(const Matrix9& covariance, const Vector9& sigma) {
  return sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
}

// 4000 runs estimate a correlation to 1.6 %; 45 different entries, hence four sigma.
TEST(PreintegrationNoise, CovarianceIsThatOfMonteCarlo) {
  constexpr int kRuns = 4000;
  constexpr double kTolerance = 4.0 / 63.0;  // 4 / sqrt(4000), diagonal sqrt(2) larger
  const ImuData clean = testing::VibratingMotion().Measure(0.0, 1.2, 100.0);
  const Preintegrated reference = Preintegrate(clean, 0.1, 1.1, {}, kNoise);
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  const double sigma_w = kNoise.gyro_white_rad_per_sqrt_s * 10.0;  // white / sqrt(0.01 s)
  const double sigma_f = kNoise.accel_white_mps_per_sqrt_s * 10.0;
  Matrix9 sum = Matrix9::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ImuData noisy = clean;
    for (ImuSample& sample : noisy.samples) {
      for (int i = 0; i < 3; ++i) {
        sample.w_ib_b_radps[i] += sigma_w * normal(rng);
        sample.f_b_mps2[i] += sigma_f * normal(rng);
      }
    }
    const Vector9 d = Difference(Preintegrate(noisy, 0.1, 1.1, {}, kNoise), reference);
    sum += d * d.transpose();
  }
  const Vector9 sigma = reference.covariance.diagonal().cwiseSqrt();
  const Matrix9 difference = Normalised(sum / kRuns - reference.covariance, sigma);
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), std::sqrt(2.0) * kTolerance) << difference;
}

TEST(PreintegrationNoise, CovarianceDoesNotDependOnTheSampling) {
  const testing::EarthMotion motion = testing::PlaneMotion();
  const Matrix9 fast =
      Preintegrate(motion.Measure(0.0, 1.0, 400.0), 0.0, 1.0, {}, kNoise).covariance;
  const Matrix9 slow =
      Preintegrate(motion.Measure(0.0, 1.0, 50.0), 0.0, 1.0, {}, kNoise).covariance;
  const Vector9 sigma = fast.diagonal().cwiseSqrt();
  EXPECT_LE(Normalised(slow - fast, sigma).cwiseAbs().maxCoeff(), 1e-4);
}

// Also of a single sample, of a part of one, and without accelerometer noise.
TEST(PreintegrationNoise, CovarianceIsSymmetricAndPositive) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 1.0, 200.0);
  for (const double end_s : {0.5005, 0.505, 0.55, 1.0}) {
    const Matrix9 P = Preintegrate(imu, 0.5, end_s, {}, kNoise).covariance;
    const Matrix9 R = Normalised(P, P.diagonal().cwiseSqrt());
    EXPECT_LE((R - R.transpose()).norm(), 1e-14);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix9>(R).eigenvalues()[0], 1e-3);

    const Matrix9 gyro = Preintegrate(imu, 0.5, end_s, {}, {2e-3, 0.0, 0.0}).covariance;
    const Eigen::SelfAdjointEigenSolver<Matrix9> solver(gyro);
    EXPECT_GE(solver.eigenvalues()[0], -1e-15 * solver.eigenvalues()[8]);
  }
}

}  // namespace
}  // namespace dn
