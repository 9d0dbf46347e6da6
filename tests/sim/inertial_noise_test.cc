// These tests check the noise of simulated inertial data in their high band. The motion of the
// flight must not affect it.
#include <dn/imu/noise_check.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "sim/small_scenario.h"
#include "testing/tolerances.h"

namespace dn::sim_test {

using testing::kSigmas;

/// Simulates a survey aircraft (navigation grade) or a drone (small sensor), at 100 Hz.
SimulatedFlight FlyWithNoise(const std::string& preset, const std::string& effects,
                             bool noise = true) {
  Scenario scenario = testing::SmallScenario("effects: [" + effects + "]\n");
  scenario.imu.rate_hz = 100.0;
  scenario.imu.model = ImuPreset(preset);
  scenario.pairs.count = 10;
  SimulateOptions options;
  options.noise = noise;
  return Simulate(scenario, options);
}

HighBand MeasureBand(const SimulatedFlight& flight) {
  return MeasureHighBand(*flight.flight.imu, flight.scenario.imu.model);
}

class InertialNoise : public ::testing::TestWithParam<const char*> {};

TEST_P(InertialNoise, MotionDoesNotShow) {
  const HighBand band = MeasureBand(FlyWithNoise(GetParam(), "", false));
  for (const ImuTriad triad : {kGyroTriad, kAccelTriad}) {
    BandEnergy sum;
    for (const HighBandWindow& window : band.windows) sum += window.Total(triad);
    EXPECT_LT(sum.Variance(), 0.001);
  }
}

TEST_P(InertialNoise, IsAsAssumed) {
  const NoiseCheck check = CheckNoise(MeasureBand(FlyWithNoise(GetParam(), "")));
  for (const auto& level : check.level) {
    ASSERT_TRUE(level);
    EXPECT_NEAR(level->ratio, 1.0, kSigmas * level->sigma);
    EXPECT_NEAR(level->tilt, 0.0, kSigmas * level->tilt_sigma);
  }
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kAssumed);
}

TEST_P(InertialNoise, MeasuresAnotherLevel) {
  const NoiseCheck check = CheckNoise(MeasureBand(FlyWithNoise(
      GetParam(),
      "{effect: gyro_noise_scale, value: 1.1}, {effect: accel_noise_scale, value: 1.5}")));
  EXPECT_NEAR(check.level[kGyroTriad]->ratio, 1.1, kSigmas * check.level[kGyroTriad]->sigma);
  EXPECT_NEAR(check.level[kAccelTriad]->ratio, 1.5, kSigmas * check.level[kAccelTriad]->sigma);
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kScale);
}

TEST_P(InertialNoise, FindsAWindow) {
  const NoiseCheck check = CheckNoise(MeasureBand(FlyWithNoise(
      GetParam(), "{effect: imu_vibration, value: [0.1, 0.3], window_s: [381150, 381180]}")));
  ASSERT_TRUE(check.window);
  const NoiseWindow& window = *check.window;
  EXPECT_NEAR(window.t0_s, 381150.0, 0.3);
  EXPECT_NEAR(window.t1_s, 381180.0, 0.3);
  EXPECT_NEAR(window.sigma[kGyroTriad], 0.1 * kRadPerDeg,
              kSigmas * window.sigma_of_sigma[kGyroTriad]);
  EXPECT_NEAR(window.sigma[kAccelTriad], 0.3, kSigmas * window.sigma_of_sigma[kAccelTriad]);
  EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kWindow);
}

INSTANTIATE_TEST_SUITE_P(Presets, InertialNoise, ::testing::Values("airins", "apx15"));

}  // namespace dn::sim_test
