#include <dn/imu/noise_check.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "imu/white_imu.h"
#include "testing/expect_invalid.h"
#include "testing/tolerances.h"

namespace dn::imu_test {

using testing::ExpectInvalid;
using testing::kSigmas;
using testing::kWhiteRateHz;
using testing::WhiteImu;
using testing::WhiteModel;

constexpr double kClear = 5.0;  ///< nats

NoiseCheck Check(const ImuData& imu) { return CheckNoise(MeasureHighBand(imu, WhiteModel())); }

/// Adds white noise of these sigmas to the samples in (t0, t1], in seconds after the beginning.
ImuData Vibrating(ImuData imu, double t0_s, double t1_s, double gyro, double accel,
                  unsigned seed = 99) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (ImuSample& sample : imu.samples) {
    const double t_s = sample.t_s - 1000.0;
    if (t_s <= t0_s || t_s > t1_s) continue;
    for (double& w : sample.w_ib_b_radps) w += gyro * normal(random);
    for (double& f : sample.f_b_mps2) f += accel * normal(random);
  }
  return imu;
}

TEST(NoiseCheck, AcceptsTheAssumedNoise) {
  constexpr int kFlights = 60;
  double sum2 = 0.0, tilt2 = 0.0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    SCOPED_TRACE(seed);
    const NoiseCheck check = Check(WhiteImu(seed, 120.0));
    EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kAssumed);
    const NoiseCauses causes = NoiseCauseEvidence(check.evidence);
    EXPECT_LT(std::max({causes.scale[0], causes.scale[1], causes.window, causes.not_white[0],
                        causes.not_white[1]}),
              0.0);
    for (const auto& level : check.level) {
      ASSERT_TRUE(level);
      sum2 += std::pow((level->ratio - 1.0) / level->sigma, 2) / (2.0 * kFlights);
      tilt2 += std::pow(level->tilt / level->tilt_sigma, 2) / (2.0 * kFlights);
    }
  }
  const double bound = kSigmas * std::sqrt(2.0 / (2.0 * kFlights));
  EXPECT_NEAR(sum2, 1.0, bound);
  EXPECT_NEAR(tilt2, 1.0, bound);
}

TEST(NoiseCheck, FindsTheRatioOfEachTriad) {
  const NoiseCheck check = Check(WhiteImu(1, 300.0, 1.05, 0.8));
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kScale);
  const NoiseLevel& gyro = *check.level[kGyroTriad];
  const NoiseLevel& accel = *check.level[kAccelTriad];
  EXPECT_NEAR(gyro.ratio, 1.05, kSigmas * gyro.sigma);
  EXPECT_NEAR(accel.ratio, 0.8, kSigmas * accel.sigma);
  EXPECT_NEAR(gyro.sigma, 1.05 / std::sqrt(2.0 * 3.0 * 0.75 * 300.0 * kWhiteRateHz), 1e-5);
  for (const double ratio : gyro.axis_ratio) EXPECT_NEAR(ratio, 1.05, kSigmas * 2.0 * gyro.sigma);
  EXPECT_LT(std::abs(gyro.tilt), kSigmas * gyro.tilt_sigma);
  const NoiseCauses causes = NoiseCauseEvidence(check.evidence);
  EXPECT_GT(causes.scale[kGyroTriad], kClear);
  EXPECT_GT(causes.scale[kAccelTriad], kClear);
  EXPECT_LT(causes.window, -1.0);
  EXPECT_LT(std::max(causes.not_white[0], causes.not_white[1]), -1.0);
}

// Both triads have more noise, as in a window that lasts the whole flight.
TEST(NoiseCheck, LargerNoiseIsNotAWindow) {
  const NoiseCauses causes = NoiseCauseEvidence(Check(WhiteImu(7, 300.0, 1.2, 1.2)).evidence);
  EXPECT_GT(causes.scale[kGyroTriad], kClear);
  EXPECT_GT(causes.scale[kAccelTriad], kClear);
  EXPECT_LT(causes.window, -kClear);
  EXPECT_LT(std::max(causes.not_white[0], causes.not_white[1]), -1.0);
}

TEST(NoiseCheck, OneTriadAloneMayHaveAnotherSize) {
  const NoiseCheck check = Check(WhiteImu(6, 120.0, 1.0, 1.1));
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kScale);
  EXPECT_LT(check.evidence.scale[kGyroTriad], 0.0);
  const NoiseCauses causes = NoiseCauseEvidence(check.evidence);
  EXPECT_LT(causes.scale[kGyroTriad], 0.0);
  EXPECT_GT(causes.scale[kAccelTriad], kClear);
}

TEST(NoiseCheck, FindsAWindow) {
  const NoiseCheck check = Check(Vibrating(WhiteImu(2, 300.0), 101.0, 143.0, 5e-4, 4e-3));
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kWindow);
  ASSERT_TRUE(check.window);
  EXPECT_NEAR(check.window->t0_s, 1101.0, 2.0);
  EXPECT_NEAR(check.window->t1_s, 1143.0, 2.0);
  EXPECT_NEAR(check.window->sigma[kGyroTriad], 5e-4,
              kSigmas * check.window->sigma_of_sigma[kGyroTriad]);
  EXPECT_NEAR(check.window->sigma[kAccelTriad], 4e-3,
              kSigmas * check.window->sigma_of_sigma[kAccelTriad]);
  EXPECT_LT(check.window->sigma_of_sigma[kGyroTriad], 5e-5);
  EXPECT_GT(check.window->log_likelihood_against_scale, kClear);
  EXPECT_GT(check.window->log_likelihood, check.window->log_likelihood_against_scale);
  const NoiseCauses causes = NoiseCauseEvidence(check.evidence);
  EXPECT_GT(causes.window, kClear);
  EXPECT_LT(causes.scale[kGyroTriad], -1.0);
  EXPECT_LT(causes.scale[kAccelTriad], -1.0);
  EXPECT_LT(std::max(causes.not_white[0], causes.not_white[1]), -1.0);
}

TEST(NoiseCheck, FindsAWindowAndAScale) {
  const NoiseCheck check = Check(Vibrating(WhiteImu(3, 300.0, 1.3, 1.0), 40.0, 80.0, 1e-3, 8e-3));
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kWindowAndScale);
  const NoiseCauses causes = NoiseCauseEvidence(check.evidence);
  EXPECT_GT(causes.window, kClear);
  EXPECT_GT(causes.scale[kGyroTriad], kClear);
  ASSERT_TRUE(check.window_with_scale);
  const NoiseWindow& window = *check.window_with_scale;
  EXPECT_NEAR(window.t0_s, 1040.0, 0.4);
  EXPECT_NEAR(window.t1_s, 1080.0, 0.4);
  EXPECT_NEAR(window.sigma[kGyroTriad], 1e-3, kSigmas * window.sigma_of_sigma[kGyroTriad]);
  EXPECT_NEAR(window.sigma[kAccelTriad], 8e-3, kSigmas * window.sigma_of_sigma[kAccelTriad]);
}

// The windows begin and end anywhere: cells that a window covers only in part are not used for its
// size.
TEST(NoiseCheck, SizesOfShortWindowsAreWithinTheirSigmas) {
  constexpr int kFlights = 24;
  double mean = 0.0, square = 0.0;
  for (int k = 0; k < kFlights; ++k) {
    const double t0_s = 20.0 + 0.07 * k;
    const auto seed = static_cast<unsigned>(200 + k);
    const ImuData imu = Vibrating(WhiteImu(seed, 60.0), t0_s, t0_s + 10.03, 0.03, 0.2, 1000 + seed);
    const NoiseCheck check = Check(imu);
    ASSERT_TRUE(check.window);
    const NoiseWindow& window = *check.window;
    for (const auto& [triad, sigma] : {std::pair{kGyroTriad, 0.03}, std::pair{kAccelTriad, 0.2}}) {
      const double z = (window.sigma[triad] - sigma) / window.sigma_of_sigma[triad];
      mean += z / (2.0 * kFlights);
      square += z * z / (2.0 * kFlights);
    }
  }
  EXPECT_NEAR(mean, 0.0, kSigmas / std::sqrt(2.0 * kFlights));
  EXPECT_NEAR(square, 1.0, kSigmas * std::sqrt(2.0 / (2.0 * kFlights)));
}

// Noise that the model contains is no longer a cause: none is found in the window or at its ends.
TEST(NoiseCheck, KnownNoiseIsNotFoundAgain) {
  const ImuData imu = Vibrating(WhiteImu(8, 200.0), 71.05, 93.02, 0.3, 2.0);  // 300 and 200 sigmas
  const NoiseWindow found = *Check(imu).window;
  ImuModel model = WhiteModel();
  model.vibration = {{found.t0_s, found.t1_s, found.sigma[kGyroTriad], found.sigma[kAccelTriad]}};
  const NoiseCheck check = CheckNoise(MeasureHighBand(imu, model));
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kAssumed);
  EXPECT_NEAR(check.level[kGyroTriad]->ratio, 1.0, kSigmas * check.level[kGyroTriad]->sigma);
  model.vibration.front().accel_sigma_mps2 = -1.0;
  ExpectInvalid([&] { MeasureHighBand(imu, model); }, "sigma", 0);
}

TEST(NoiseCheck, FindsASecondWindow) {
  const ImuData imu =
      Vibrating(Vibrating(WhiteImu(8, 300.0), 71.05, 93.02, 3e-3, 2e-2), 180.0, 220.0, 1e-3, 8e-3);
  ImuModel model = WhiteModel();
  model.vibration = {{1071.05, 1093.02, 3e-3, 2e-2}};
  const NoiseCheck check = CheckNoise(MeasureHighBand(imu, model));
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kWindow);
  ASSERT_TRUE(check.window);
  EXPECT_NEAR(check.window->t0_s, 1180.0, 0.4);
  EXPECT_NEAR(check.window->t1_s, 1220.0, 0.4);
  EXPECT_NEAR(check.window->sigma[kGyroTriad], 1e-3,
              kSigmas * check.window->sigma_of_sigma[kGyroTriad]);
}

// A running propeller causes a spectral line at 38 Hz in one axis.
TEST(NoiseCheck, ALineIsNotWhite) {
  ImuData imu = WhiteImu(4, 200.0);
  for (ImuSample& sample : imu.samples) {
    sample.w_ib_b_radps.z() += 7e-4 * std::sin(2.0 * std::numbers::pi * 38.0 * sample.t_s);
  }
  const NoiseCheck check = Check(imu);
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kNotWhite);
  EXPECT_GT(check.evidence.coloured[kGyroTriad], check.evidence.unsteady[kGyroTriad] + kClear);
  EXPECT_LT(check.evidence.coloured[kAccelTriad], 0.0);
  const NoiseCauses causes = NoiseCauseEvidence(check.evidence);
  EXPECT_GT(causes.not_white[kGyroTriad], kClear);
  EXPECT_LT(causes.not_white[kAccelTriad], 0.0);
  EXPECT_LT(causes.scale[kGyroTriad], 0.0) << "a line has no scale";
  EXPECT_LT(causes.window, 0.0);
  EXPECT_GT(check.level[kGyroTriad]->tilt, kSigmas * check.level[kGyroTriad]->tilt_sigma);
}

TEST(NoiseCheck, OneTriadMayBeWhiteWhereTheOtherIsNot) {
  ImuData imu = WhiteImu(9, 200.0, 1.0, 1.2);
  for (ImuSample& sample : imu.samples) {
    sample.w_ib_b_radps.z() += 7e-4 * std::sin(2.0 * std::numbers::pi * 38.0 * sample.t_s);
  }
  const NoiseCauses causes = NoiseCauseEvidence(Check(imu).evidence);
  EXPECT_GT(causes.not_white[kGyroTriad], kClear);
  EXPECT_LT(causes.scale[kGyroTriad], 0.0);
  EXPECT_GT(causes.scale[kAccelTriad], kClear);
}

TEST(NoiseCheck, IntermittentNoiseIsUnsteady) {
  ImuData imu = WhiteImu(5, 200.0);
  for (int k = 0; k < 10; ++k) imu = Vibrating(imu, 20.0 * k, 20.0 * k + 4.0 + k, 8e-4, 6e-3);
  const NoiseCheck check = Check(imu);
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kNotWhite);
  for (const ImuTriad triad : {kGyroTriad, kAccelTriad}) {
    EXPECT_GT(check.evidence.unsteady[triad], check.evidence.coloured[triad] + kClear);
  }
}

/// Returns a window with these energies per axis and octave of the gyro; the accelerometer is
/// unusable.
HighBandWindow GyroWindow(double t0_s, double sum, double dof) {
  HighBandWindow window;
  window.t0_s = t0_s;
  window.t1_s = t0_s + 2.0;
  for (auto& axis : window.energy[kGyroTriad]) axis.fill({sum, dof});
  return window;
}

HighBand GyroBand(const std::vector<HighBandWindow>& windows) {
  HighBand band;
  band.triads[kGyroTriad].assumed_sigma = 1e-3;
  band.triads[kAccelTriad].assumed_sigma = 1e-2;
  band.triads[kAccelTriad].unusable = "absent";
  band.windows = windows;
  return band;
}

double Integral(double from, double to, const std::function<double(double)>& f) {
  constexpr int kSteps = 100000;
  const double step = (to - from) / kSteps;
  double sum = 0.0;
  for (int k = 0; k < kSteps; ++k) sum += step * f(from + (k + 0.5) * step);
  return sum;
}

double Normal(double x, double sigma) {
  return std::exp(-0.5 * x * x / (sigma * sigma)) / (sigma * std::sqrt(2.0 * std::numbers::pi));
}

double Likelihood(double sum, double dof, double v) {
  return std::exp(-0.5 * (dof * std::log(v) + sum * (1.0 / v - 1.0)));
}

TEST(NoiseCheck, EvidenceOfAScaleIsItsIntegral) {
  const std::vector<std::pair<double, double>> prior{
      {0.1, 0.1}, {0.2, std::sqrt(0.1)}, {0.4, 1.0}, {0.2, std::sqrt(10.0)}, {0.1, 10.0}};
  for (const double variance : {0.8, 1.0, 1.3}) {
    constexpr double kDof = 600.0;
    const HighBand band = GyroBand({GyroWindow(0.0, variance * kDof / 6.0, kDof / 6.0)});
    const double integral = Integral(-1.0, 1.0, [&](double u) {
      double density = 0.0;
      for (const auto& [weight, scale] : prior) {
        density += weight * Normal(u, scale * std::log(1.5));
      }
      return density * Likelihood(variance * kDof, kDof, std::exp(2.0 * u));
    });
    const NoiseCheck check = CheckNoise(band);
    EXPECT_NEAR(check.evidence.scale[kGyroTriad], std::log(integral), 0.05) << variance;
    EXPECT_FALSE(check.level[kAccelTriad]);
    EXPECT_EQ(check.evidence.scale[kAccelTriad], 0.0);
  }
}

// There are two windows: the first, the second or both may have additional noise.
TEST(NoiseCheck, EvidenceOfAWindowIsTheAverageOverAll) {
  NoiseCheckOptions options;
  options.typical_sigma[kGyroTriad] = 4e-4;
  const std::vector<double> dofs{300.0, 900.0};
  for (const double variance : {0.9, 1.05, 1.2, 1.8}) {
    const std::vector<double> sums{variance * dofs[0], dofs[1]};
    const HighBand band = GyroBand({GyroWindow(0.0, sums[0] / 6.0, dofs[0] / 6.0),
                                    GyroWindow(2.0, sums[1] / 6.0, dofs[1] / 6.0)});
    const auto evidence = [&](double sum, double dof) {
      return Integral(-5.0, 3.0, [&](double x) {
        return Normal(x, 0.7) * Likelihood(sum, dof, 1.0 + std::pow(0.4 * std::pow(10.0, x), 2));
      });
    };
    const double mean = (evidence(sums[0], dofs[0]) + evidence(sums[1], dofs[1]) +
                         evidence(sums[0] + sums[1], dofs[0] + dofs[1])) /
                        3.0;
    EXPECT_NEAR(CheckNoise(band, options).evidence.window, std::log(mean), 0.1) << variance;
  }
}

TEST(NoiseCheck, UnusableTriadsGiveNoResult) {
  HighBand band = GyroBand({GyroWindow(0.0, 0.0, 0.0)});
  band.triads[kGyroTriad].unusable = "absent";
  const NoiseCheck check = CheckNoise(band);
  EXPECT_FALSE(check.level[kGyroTriad]);
  EXPECT_FALSE(check.window);
  EXPECT_EQ(check.evidence.window, 0.0);
}

TEST(NoiseCheck, OptionsHaveBounds) {
  const HighBand band = GyroBand({GyroWindow(0.0, 100.0, 100.0)});
  ExpectInvalid([&] { CheckNoise(band, {.typical_ratio = 1.0}); }, "typical_ratio", 0);
  ExpectInvalid([&] { CheckNoise(band, {.typical_sigma = {1.0, 0.0}}); }, "typical_sigma", 0);
  ExpectInvalid([&] { CheckNoise(band, {.spread_decades = -1.0}); }, "spread_decades", 0);
}

}  // namespace dn::imu_test
