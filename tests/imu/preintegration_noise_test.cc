#include <dn/error.h>
#include <dn/imu/preintegration.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "testing/earth_motion.h"

namespace dn::imu_test {

using Eigen::Vector3d;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

// The sensors are poor, so that every term of the covariance matters.
const PreintegrationNoise kLargeNoise{2e-3, 5e-3, 0.0};

Vector9 Difference(const Preintegrated& noisy, const Preintegrated& clean) {
  Vector9 d;
  d << Log(Eigen::Quaterniond(clean.delta_q.conjugate() * noisy.delta_q)),
      noisy.delta_v - clean.delta_v, noisy.delta_p - clean.delta_p;
  return d;
}

/// Divides by the standard deviations, so that every entry has the same weight.
Matrix9 Normalised(const Matrix9& covariance, const Vector9& sigma) {
  return sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
}

// A correlation from 4000 runs has an error of 1.6 %; since there are 45 different entries, the
// tolerance is four sigmas.
TEST(PreintegrationNoise, CovarianceIsThatOfMonteCarlo) {
  constexpr int kRuns = 4000;
  constexpr double kTolerance = 4.0 / 63.0;  // 4 / sqrt(4000); the diagonal has sqrt(2) times more
  const ImuData clean = testing::VibratingMotion().Measure(0.0, 1.2, 100.0);
  const Preintegrated reference = Preintegrate(clean, 0.1, 1.1, {}, kLargeNoise);
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  const double sigma_w = kLargeNoise.gyro_white_rad_per_sqrt_s * 10.0;  // white / sqrt(0.01 s)
  const double sigma_f = kLargeNoise.accel_white_mps_per_sqrt_s * 10.0;
  Matrix9 sum = Matrix9::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ImuData noisy = clean;
    for (ImuSample& sample : noisy.samples) {
      for (int i = 0; i < 3; ++i) {
        sample.w_ib_b_radps[i] += sigma_w * normal(rng);
        sample.f_b_mps2[i] += sigma_f * normal(rng);
      }
    }
    const Vector9 d = Difference(Preintegrate(noisy, 0.1, 1.1, {}, kLargeNoise), reference);
    sum += d * d.transpose();
  }
  const Vector9 sigma = reference.covariance.diagonal().cwiseSqrt();
  const Matrix9 difference = Normalised(sum / kRuns - reference.covariance, sigma);
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), std::sqrt(2.0) * kTolerance) << difference;
}

/// Returns the variance of an angle or velocity over `all` samples of 0.01 s. The sensor vibrates
/// in `inside` of them.
double Variance(double white, double sigma, int inside, int all) {
  return 0.01 * all * white * white + 1e-4 * inside * sigma * sigma;
}

// The window contains samples 31 to 50 of 10 to 110. The motion has no rotation, so that angle and
// velocity can be computed by hand.
TEST(PreintegrationNoise, VibrationAddsToTheSamplesOfItsWindow) {
  ImuData imu = testing::VibratingMotion().Measure(0.0, 1.2, 100.0);
  for (ImuSample& sample : imu.samples) {
    sample.w_ib_b_radps.setZero();
    sample.f_b_mps2.setZero();
  }
  PreintegrationNoise noise = kLargeNoise;
  noise.vibration = {{0.305, 0.4, 0.05, 0.2}, {0.404, 0.505, 0.05, 0.0}};
  const auto covariance = [&](double t0_s, double t1_s) {
    return Preintegrate(imu, t0_s, t1_s, {}, noise).covariance;
  };
  constexpr double kRelative = 1e-9;
  const auto expect = [&](double actual, double expected) {
    EXPECT_NEAR(actual, expected, kRelative * expected);
  };
  const Matrix9 P = covariance(0.1, 1.1);
  expect(P(0, 0), Variance(2e-3, 0.05, 20, 100));
  expect(P(3, 3), Variance(5e-3, 0.2, 10, 100));
  // The interval contains a quarter of sample 31 and half of sample 51, which does not vibrate.
  expect(covariance(0.3075, 0.505)(0, 0), 0.1975 * 4e-6 + 19.25 * 1e-4 * 0.05 * 0.05);
  expect(covariance(0.6, 0.8)(0, 0), Variance(2e-3, 0.0, 0, 20));
}

TEST(PreintegrationNoise, RefusesVibrationThatIsNegative) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 1.2, 100.0);
  PreintegrationNoise noise = kLargeNoise;
  noise.vibration = {{0.3, 0.4, 0.1, -0.2}};
  EXPECT_THROW(Preintegrate(imu, 0.1, 1.1, {}, noise), InvalidInput);
}

// The increments are those of a motion with rotation; the window begins and ends within them.
TEST(PreintegrationNoise, CovarianceOfVibrationIsThatOfMonteCarlo) {
  constexpr int kRuns = 4000;
  constexpr double kTolerance = 4.0 / 63.0;  // as in CovarianceIsThatOfMonteCarlo
  const ImuData clean = testing::VibratingMotion().Measure(0.0, 1.2, 100.0);
  const ImuVibration vibration{0.405, 0.755, 0.05, 0.15};
  const PreintegrationNoise noise{1e-6, 1e-6, 0.0, {vibration}};
  const Preintegrated reference = Preintegrate(clean, 0.1, 1.1, {}, noise);
  std::mt19937 rng(8);
  std::normal_distribution<double> normal;
  Matrix9 sum = Matrix9::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ImuData noisy = clean;
    for (ImuSample& sample : noisy.samples) {
      if (!vibration.Covers(sample.t_s)) continue;
      for (int i = 0; i < 3; ++i) {
        sample.w_ib_b_radps[i] += vibration.gyro_sigma_radps * normal(rng);
        sample.f_b_mps2[i] += vibration.accel_sigma_mps2 * normal(rng);
      }
    }
    const Vector9 d = Difference(Preintegrate(noisy, 0.1, 1.1, {}, noise), reference);
    sum += d * d.transpose();
  }
  const Vector9 sigma = reference.covariance.diagonal().cwiseSqrt();
  const Matrix9 difference = Normalised(sum / kRuns - reference.covariance, sigma);
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), std::sqrt(2.0) * kTolerance) << difference;
}

TEST(PreintegrationNoise, CovarianceDoesNotDependOnTheSampling) {
  const testing::EarthMotion motion = testing::PlaneMotion();
  const Matrix9 fast =
      Preintegrate(motion.Measure(0.0, 1.0, 400.0), 0.0, 1.0, {}, kLargeNoise).covariance;
  const Matrix9 slow =
      Preintegrate(motion.Measure(0.0, 1.0, 50.0), 0.0, 1.0, {}, kLargeNoise).covariance;
  const Vector9 sigma = fast.diagonal().cwiseSqrt();
  EXPECT_LE(Normalised(slow - fast, sigma).cwiseAbs().maxCoeff(), 1e-4);
}

// The test includes a single sample, a part of a sample, and no accelerometer noise.
TEST(PreintegrationNoise, CovarianceIsSymmetricAndPositive) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 1.0, 200.0);
  for (const double end_s : {0.5005, 0.505, 0.55, 1.0}) {
    const Matrix9 P = Preintegrate(imu, 0.5, end_s, {}, kLargeNoise).covariance;
    const Matrix9 R = Normalised(P, P.diagonal().cwiseSqrt());
    EXPECT_LE((R - R.transpose()).norm(), 1e-14);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix9>(R).eigenvalues()[0], 1e-3);

    const Matrix9 gyro = Preintegrate(imu, 0.5, end_s, {}, {2e-3, 0.0, 0.0}).covariance;
    const Eigen::SelfAdjointEigenSolver<Matrix9> solver(gyro);
    EXPECT_GE(solver.eigenvalues()[0], -1e-15 * solver.eigenvalues()[8]);
  }
}

}  // namespace dn::imu_test
