#include <dn/imu/shaking.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "white_imu.h"

namespace dn::imu_test {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Adds a line to the rate about x, a quarter of a period later to the rate about y, and to the
/// vertical force.
void AddLine(double frequency_hz, double rate_radps, double accel_mps2, ImuData* imu) {
  for (ImuSample& sample : imu->samples) {
    const double angle = kTwoPi * frequency_hz * sample.t_s;
    sample.w_ib_b_radps.x() += std::numbers::sqrt2 * rate_radps * std::sin(angle);
    sample.w_ib_b_radps.y() += std::numbers::sqrt2 * rate_radps * std::cos(angle);
    sample.f_b_mps2.z() += std::numbers::sqrt2 * accel_mps2 * std::sin(angle);
  }
}

TEST(Shaking, WhiteNoiseIsCalm) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto shaking = FindShaking(testing::WhiteImu(seed, 300.0));
    ASSERT_TRUE(shaking.has_value());
    EXPECT_TRUE(shaking->calm()) << seed;
  }
}

TEST(Shaking, FindsLinesAndTheirLevels) {
  constexpr double kRate_radps = 2e-3, kAccel_mps2 = 0.5;
  ImuData imu = testing::WhiteImu(4, 300.0);
  AddLine(21.3, kRate_radps, kAccel_mps2, &imu);
  AddLine(38.0, 0.5 * kRate_radps, 0.2 * kAccel_mps2, &imu);
  const auto shaking = FindShaking(imu);
  ASSERT_TRUE(shaking.has_value());
  EXPECT_FALSE(shaking->calm());
  ASSERT_EQ(shaking->lines.size(), 2u);
  const ShakingLine& line = shaking->lines[0];
  EXPECT_NEAR(line.frequency_hz, 21.3, 0.1);
  EXPECT_NEAR(shaking->lines[1].frequency_hz, 38.0, 0.1);
  EXPECT_NEAR(line.rate_radps.x(), kRate_radps, 0.05 * kRate_radps);
  EXPECT_NEAR(line.accel_mps2.z(), kAccel_mps2, 0.05 * kAccel_mps2);
  EXPECT_NEAR(shaking->turn_rad, kRate_radps / (kTwoPi * 21.3), 0.1 * kRate_radps / kTwoPi / 21.3);
}

// Rates in quadrature are a coning motion: the limit is the drift that the samples miss.
TEST(Shaking, ConingIsWhatTheSamplesMiss) {
  constexpr double kRate_radps = 0.02, kFrequency_hz = 30.0;
  ImuData imu = testing::WhiteImu(5, 300.0, 0.01, 0.01);
  AddLine(kFrequency_hz, kRate_radps, 0.0, &imu);
  const double w = kTwoPi * kFrequency_hz, x = w * imu.nominal_dt_s;
  const double missed =
      std::abs(1.0 - std::sin(x) / x - (1.0 - std::cos(x)) * std::sin(x) / (3.0 * x));
  const double drift_radps = missed * kRate_radps * kRate_radps / w;
  EXPECT_NEAR(FindShaking(imu)->coning_radps, drift_radps, 0.1 * drift_radps);
}

TEST(Shaking, NeedsThreeRegularParts) {
  EXPECT_FALSE(FindShaking(testing::WhiteImu(6, 10.0)).has_value());
  EXPECT_FALSE(FindShaking(ImuData{}).has_value());
}

}  // namespace dn::imu_test
