#include <dn/imu/high_band.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "imu/white_imu.h"
#include "testing/expect_invalid.h"
#include "testing/tolerances.h"

namespace dn::imu_test {

using testing::ExpectInvalid;
using testing::kSigmas;
using testing::kWhiteRateHz;
using testing::WhiteImu;
using testing::WhiteModel;

const HighBandOptions kTwoSeconds{.window_s = 2.0};

BandEnergy Sum(const HighBand& band, ImuTriad triad, std::size_t axis, ImuOctave octave) {
  BandEnergy sum;
  for (const HighBandWindow& window : band.windows) sum += window.At(triad, axis, octave);
  return sum;
}

BandEnergy Sum(const HighBand& band, ImuTriad triad) {
  BandEnergy sum;
  for (const HighBandWindow& window : band.windows) sum += window.Total(triad);
  return sum;
}

/// Returns the difference of the variance from the assumed one, in sigmas.
double Departure(const BandEnergy& energy) {
  return (energy.Variance() - 1.0) / std::sqrt(2.0 / energy.dof);
}

/// Returns the mean square of Departure over all windows, axes and octaves. It is 1 if the degrees
/// of freedom are right.
double MeanSquareDeparture(const HighBand& band) {
  double sum = 0.0, count = 0.0;
  for (const HighBandWindow& window : band.windows) {
    for (const auto& triad : window.energy) {
      for (const auto& axis : triad) {
        for (const BandEnergy& octave : axis) {
          sum += std::pow(Departure(octave), 2);
          count += 1.0;
        }
      }
    }
  }
  return sum / count;
}

ImuData Changed(ImuData imu, const std::function<void(double t_s, ImuSample*)>& change) {
  for (ImuSample& sample : imu.samples) change(sample.t_s - 1000.0, &sample);
  return imu;
}

TEST(HighBand, WhiteNoiseOfTheAssumedDensityHasVarianceOne) {
  const HighBand band = MeasureHighBand(WhiteImu(1, 400.0), WhiteModel(), kTwoSeconds);
  EXPECT_EQ(band.windows.size(), 200U);
  EXPECT_NEAR(band.triads[kGyroTriad].assumed_sigma, 1e-3, 1e-15);
  EXPECT_NEAR(band.triads[kAccelTriad].assumed_sigma, 1e-2, 1e-15);
  for (const ImuTriad triad : {kGyroTriad, kAccelTriad}) {
    EXPECT_EQ(band.triads[triad].unusable, "");
    EXPECT_EQ(band.triads[triad].rounding, 0.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const BandEnergy top = Sum(band, triad, axis, kTopOctave);
      EXPECT_NEAR(top.dof, 0.5 * 400.0 * kWhiteRateHz, 10.0);
      EXPECT_LT(std::abs(Departure(top)), kSigmas);
      EXPECT_LT(std::abs(Departure(Sum(band, triad, axis, kSecondOctave))), kSigmas);
    }
  }
  EXPECT_NEAR(MeanSquareDeparture(band), 1.0, 0.15);
}

TEST(HighBand, SeparatesTheOctaves) {
  constexpr double kAmplitude = 0.01;  // a hundred times the noise variance / 2
  for (const auto& [hz, octave, other] :
       {std::tuple(38.0, kTopOctave, kSecondOctave), std::tuple(18.0, kSecondOctave, kTopOctave)}) {
    const double omega = 2.0 * std::numbers::pi * hz;
    const HighBand band = MeasureHighBand(Changed(WhiteImu(2, 100.0),
                                                  [&](double t_s, ImuSample* s) {
                                                    s->w_ib_b_radps.y() +=
                                                        kAmplitude * std::sin(omega * t_s);
                                                  }),
                                          WhiteModel());
    const double in = Sum(band, kGyroTriad, 1, octave).Variance();
    EXPECT_GT(in, 50.0);
    EXPECT_LT(Sum(band, kGyroTriad, 1, other).Variance(), 0.1 * in);
    EXPECT_LT(std::abs(Departure(Sum(band, kGyroTriad, 0, octave))), kSigmas);
  }
}

// The turns and turbulence are a thousand times the noise and slower than an eighth of the sampling
// rate.
TEST(HighBand, MotionDoesNotShow) {
  const HighBand still = MeasureHighBand(WhiteImu(3, 100.0), WhiteModel());
  const HighBand moving = MeasureHighBand(
      Changed(WhiteImu(3, 100.0),
              [](double t_s, ImuSample* s) {
                s->w_ib_b_radps.x() += 1.0 * std::sin(0.6 * t_s) + 0.01 * std::sin(12.0 * t_s);
                s->f_b_mps2.z() += 1e-3 * t_s * t_s + 1e-5 * t_s * t_s * t_s;
              }),
      WhiteModel());
  EXPECT_NEAR(Sum(moving, kGyroTriad).Variance(), Sum(still, kGyroTriad).Variance(), 1e-3);
  EXPECT_NEAR(Sum(moving, kAccelTriad).Variance(), Sum(still, kAccelTriad).Variance(), 1e-3);
}

TEST(HighBand, WindowsContainOnlyTheirOwnTime) {
  HighBandOptions options;
  options.window_s = 5.0;
  const HighBand band = MeasureHighBand(Changed(WhiteImu(4, 52.0),
                                                [](double t_s, ImuSample* s) {
                                                  if (t_s > 20.0 && t_s <= 25.0) s->f_b_mps2 *= 2.0;
                                                }),
                                        WhiteModel(), options);
  ASSERT_EQ(band.windows.size(), 11U);
  EXPECT_NEAR(band.windows[4].t0_s, 1020.0, 1e-9);
  EXPECT_NEAR(band.windows.back().t1_s, 1052.0, 1e-9);
  for (std::size_t k = 0; k < band.windows.size(); ++k) {
    const double variance = band.windows[k].Total(kAccelTriad).Variance();
    if (k == 4 || k == 3 || k == 5) continue;  // the steps at the ends of the window
    EXPECT_NEAR(variance, 1.0, kSigmas * std::sqrt(2.0 / band.windows[k].Total(kAccelTriad).dof));
  }
}

// Across the gap the rate jumps by hundreds of sigmas: no coefficient may contain samples of both
// sides.
TEST(HighBand, NoCoefficientSpansAGap) {
  ImuData imu = Changed(WhiteImu(5, 100.0), [](double t_s, ImuSample* s) {
    if (t_s > 50.0) s->w_ib_b_radps.x() += 1.0;
  });
  std::erase_if(imu.samples,
                [](const ImuSample& s) { return s.t_s > 1049.0 && s.t_s < 1051.0 + 1e-6; });
  const HighBand gap = MeasureHighBand(imu, WhiteModel(), kTwoSeconds);
  EXPECT_LT(std::abs(Departure(Sum(gap, kGyroTriad))), kSigmas);
  EXPECT_LT(gap.windows[24].Total(kGyroTriad).dof + gap.windows[25].Total(kGyroTriad).dof,
            0.55 * 2.0 * gap.windows[3].Total(kGyroTriad).dof);

  CloseShortHoles(3.0, &imu);  // the same hole as a bridge: one sample of two seconds
  ASSERT_EQ(imu.bridges.size(), 1U);
  EXPECT_LT(std::abs(Departure(Sum(MeasureHighBand(imu, WhiteModel()), kGyroTriad))), kSigmas);
}

TEST(HighBand, AWeekHasNoMoreThan50000Windows) {
  ImuData imu = WhiteImu(11, 20.0);
  for (std::size_t k = imu.samples.size() / 2; k < imu.samples.size(); ++k) {
    imu.samples[k].t_s += 604800.0;
  }
  const HighBand band = MeasureHighBand(imu, WhiteModel());
  EXPECT_LE(band.windows.size(), 50000U);
  EXPECT_NEAR(Sum(band, kGyroTriad).dof, 20.0 * 3.0 * 0.75 * kWhiteRateHz, 150.0);
  EXPECT_LT(std::abs(Departure(Sum(band, kGyroTriad))), kSigmas);
}

TEST(HighBand, ARepeatingSensorIsNotUsed) {
  Eigen::Vector3d held = Eigen::Vector3d::Zero();
  int k = 0;
  const HighBand band = MeasureHighBand(Changed(WhiteImu(6, 50.0),
                                                [&](double, ImuSample* s) {
                                                  if (k++ % 3 == 2) s->f_b_mps2 = held;
                                                  held = s->f_b_mps2;
                                                }),
                                        WhiteModel());
  EXPECT_NEAR(band.triads[kAccelTriad].repeated_share, 1.0 / 3.0, 0.01);
  EXPECT_EQ(band.triads[kAccelTriad].unusable, "33 % of its samples repeat the sample before");
  EXPECT_EQ(Sum(band, kAccelTriad).dof, 0.0);
  EXPECT_EQ(band.triads[kGyroTriad].unusable, "") << "the gyro does not repeat";
  EXPECT_LT(std::abs(Departure(Sum(band, kGyroTriad))), kSigmas);
}

ImuData Rounded(ImuData imu, double step, double digits) {
  for (ImuSample& sample : imu.samples) {
    for (double& value : sample.w_ib_b_radps) {
      value = std::round(std::round(value / step) * step / digits) * digits;
    }
  }
  return imu;
}

// The data have steps of one sigma, written with fewer digits than they have. The rounding must be
// included.
TEST(HighBand, RoundingIsPartOfTheNoise) {
  const HighBand band = MeasureHighBand(Rounded(WhiteImu(7, 100.0), 1.0003e-3, 1e-7), WhiteModel());
  EXPECT_NEAR(band.triads[kGyroTriad].rounding, 1.0 / 12.0, 0.002);
  EXPECT_LT(std::abs(Departure(Sum(band, kGyroTriad))), kSigmas);
}

TEST(HighBand, ACoarseSensorIsNotUsed) {
  const HighBand band = MeasureHighBand(Rounded(WhiteImu(8, 100.0), 5e-3, 1e-7), WhiteModel());
  EXPECT_EQ(band.triads[kGyroTriad].unusable, "its resolution is coarser than its noise");
  EXPECT_EQ(band.triads[kAccelTriad].unusable, "");
}

// For means of the two ends of each interval, point samples of the assumed density have variance
// one.
TEST(HighBand, AllowsForMeansOfPointSamples) {
  ImuData imu = WhiteImu(9, 400.0);
  for (std::size_t k = imu.samples.size() - 1; k > 0; --k) {
    ImuSample &sample = imu.samples[k], &before = imu.samples[k - 1];
    sample.w_ib_b_radps = 0.5 * (sample.w_ib_b_radps + before.w_ib_b_radps);
    sample.f_b_mps2 = 0.5 * (sample.f_b_mps2 + before.f_b_mps2);
  }
  EXPECT_LT(Sum(MeasureHighBand(imu, WhiteModel()), kGyroTriad, 0, kTopOctave).Variance(), 0.3);
  HighBandOptions options = kTwoSeconds;
  options.sampling = ImuSampling::kInstantaneous;
  const HighBand band = MeasureHighBand(imu, WhiteModel(), options);
  for (const ImuTriad triad : {kGyroTriad, kAccelTriad}) {
    EXPECT_LT(std::abs(Departure(Sum(band, triad))), kSigmas);
  }
  EXPECT_NEAR(MeanSquareDeparture(band), 1.0, 0.15);
}

TEST(HighBand, AFewSamplesAreUnusable) {
  ImuData imu = WhiteImu(10, 0.05);
  const HighBand band = MeasureHighBand(imu, WhiteModel());
  EXPECT_EQ(band.triads[kGyroTriad].unusable, "it has no continuous samples at equal intervals");
  HighBandOptions options;
  options.window_s = 0.0;
  ExpectInvalid([&] { MeasureHighBand(imu, WhiteModel(), options); }, "window_s", 0);
}

}  // namespace dn::imu_test
