#include <dn/imu/white_rows.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "white_imu.h"

namespace dn::imu_test {

// The axis with the most noise of 100 rows exceeds the density by some percent.
constexpr double kRelative = 0.2;

void ExpectDensity(const ImuData& imu) {
  const WhiteNoiseDensities found = EstimateWhiteNoise(imu);
  EXPECT_NEAR(found.gyro_rad_per_sqrt_s / 1e-4, 1.0, kRelative);
  EXPECT_NEAR(found.accel_mps_per_sqrt_s / 1e-3, 1.0, kRelative);
}

TEST(WhiteNoiseDensities, FindsTheDensityDuringMotion) {
  ImuData imu = testing::WhiteImu(100, 60.0);
  ExpectDensity(imu);
  for (ImuSample& sample : imu.samples) sample.w_ib_b_radps.x() += 0.1 * std::sin(sample.t_s);
  ExpectDensity(imu);
}

/// Adds an engine with harmonics from `begin_s` on, a hundred times the noise.
void StartEngine(double begin_s, ImuData* imu) {
  for (ImuSample& sample : imu->samples) {
    if (sample.t_s < imu->samples.front().t_s + begin_s) continue;
    for (const double hz : {13.1, 26.2, 39.3}) {
      const double wave = std::sin(2.0 * std::numbers::pi * hz * sample.t_s);
      sample.w_ib_b_radps += 0.1 * wave * Eigen::Vector3d::Ones();
      sample.f_b_mps2 += 1.0 * wave * Eigen::Vector3d::Ones();
    }
  }
}

TEST(WhiteNoiseDensities, AreThoseBeforeTheEngineStarts) {
  ImuData imu = testing::WhiteImu(101, 600.0);
  StartEngine(100.0, &imu);
  ExpectDensity(imu);
  EXPECT_FALSE(EstimateWhiteNoise(imu).shaking);
}

TEST(WhiteNoiseDensities, LieBetweenTheLinesOfAnEngineThatNeverStops) {
  ImuData imu = testing::WhiteImu(102, 600.0);
  StartEngine(0.0, &imu);
  ExpectDensity(imu);
  EXPECT_TRUE(EstimateWhiteNoise(imu).shaking);
}

// The logger writes each row of its sensor three times.
TEST(WhiteNoiseDensities, IgnoresRepeatedRows) {
  ImuData imu = testing::WhiteImu(100, 60.0), log = imu;
  log.samples.clear();
  for (const ImuSample& sample : imu.samples) {
    for (int i = 0; i < 3; ++i) {
      log.samples.push_back(sample);
      log.samples.back().t_s += (i - 2) * imu.nominal_dt_s / 3.0;
    }
  }
  ExpectDensity(log);
}

TEST(WhiteNoiseDensities, ZeroForFewRows) {
  ImuData imu = testing::WhiteImu(100, 0.03);
  EXPECT_EQ(EstimateWhiteNoise(imu).gyro_rad_per_sqrt_s, 0.0);
}

}  // namespace dn::imu_test
