#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "sim/small_scenario.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

constexpr double kImuRate_hz = 100.0, kShake_mps2 = 0.5;

/// Flies one line with vibration at one frequency, without turbulence and noise.
SimulatedFlight FlySampled(double vibration_hz, ImuSampling sampling,
                           std::optional<double> filter_hz) {
  Scenario scenario = testing::SmallScenario();
  scenario.plan.turbulence = {};
  scenario.plan.vibration.lines = {
      {vibration_hz, {Eigen::Vector3d::Constant(kShake_mps2), {0.0, 0.0, 0.0}}, 1, 0.0}};
  scenario.plan.warm_up_s = 0.0;
  scenario.plan.lines.resize(1);
  scenario.pairs.count = 0;
  scenario.imu.rate_hz = kImuRate_hz;
  scenario.imu.sampling = sampling;
  scenario.imu.filter_hz = filter_hz;
  SimulateOptions options;
  options.noise = false;
  return Simulate(scenario, options);
}

/// Returns the complex amplitude of the vertical force at a frequency, with its phase at t = 0.
std::complex<double> ForceAt(const SimulatedFlight& flight, double frequency_hz) {
  std::complex<double> sum = 0.0;
  double weights = 0.0;
  const StripInterval& strip = flight.strips.front();
  for (const ImuRow& row : flight.imu_rows) {
    if (row.t_s < strip.t0_s || row.t_s > strip.t1_s) continue;
    const double share = (row.t_s - strip.t0_s) / (strip.t1_s - strip.t0_s);
    const double weight = std::pow(std::sin(std::numbers::pi * share), 4);
    const double t_s = row.t_s - strip.t0_s;
    sum +=
        weight * row.f_b_mps2.z() * std::polar(1.0, -2.0 * std::numbers::pi * frequency_hz * t_s);
    weights += weight;
  }
  return 2.0 / weights * sum;
}

TEST(SensorSampling, PointSamplesAreTheTrueValues) {
  const SimulatedFlight flight = FlySampled(30.0, ImuSampling::kInstantaneous, {});
  for (std::size_t k = 0; k < flight.imu_rows.size(); k += 17) {
    const TruthState truth = flight.truth->State(flight.imu_rows[k].t_s);
    EXPECT_LT((flight.imu_rows[k].f_b_mps2 - truth.f_b).norm(), 1e-9);
    EXPECT_LT((flight.imu_rows[k].w_ib_b_radps - truth.w_ib_b).norm(), 1e-12);
  }
}

TEST(SensorSampling, WrittenPointSamplesReadBackAsTheFlightInMemory) {
  const SimulatedFlight flight = FlySampled(30.0, ImuSampling::kInstantaneous, {});
  const testing::TempFolder folder;
  OutputDirectory directory(folder.path() / "flight");
  WriteFlight(flight, directory);
  directory.Commit();
  const ImuData read = *ReadFlight(folder.path() / "flight", {.imu = true}).imu;
  ASSERT_EQ(read.samples.size(), flight.flight.imu->samples.size());
  EXPECT_EQ(read.samples.size(), flight.gyro_bias_radps.size());
  for (std::size_t k = 0; k < read.samples.size(); ++k) {
    EXPECT_EQ(read.samples[k].f_b_mps2, flight.flight.imu->samples[k].f_b_mps2);
    EXPECT_EQ(read.samples[k].dt_s, flight.flight.imu->samples[k].dt_s);
  }
}

// 80 Hz appear at 20 Hz in samples of 100 Hz. The filter has the gain (80 / 25)^-4 there.
TEST(SensorSampling, AFilterRemovesTheAlias) {
  constexpr double kShaken_hz = 80.0, kSeen_hz = kImuRate_hz - kShaken_hz, kFilter_hz = 25.0;
  const double amplitude_mps2 = std::numbers::sqrt2 * kShake_mps2;
  const SimulatedFlight open = FlySampled(kShaken_hz, ImuSampling::kInstantaneous, {});
  EXPECT_NEAR(std::abs(ForceAt(open, kSeen_hz)), amplitude_mps2, 0.02 * amplitude_mps2);
  const SimulatedFlight filtered = FlySampled(kShaken_hz, ImuSampling::kInstantaneous, kFilter_hz);
  const double gain = 1.0 / std::sqrt(1.0 + std::pow(kShaken_hz / kFilter_hz, 8));
  // The filter is simulated in steps, whose response falls off a little faster.
  EXPECT_LT(std::abs(ForceAt(filtered, kSeen_hz)), 1.02 * gain * amplitude_mps2);
}

// The phase is that of the analogue filter without its delay of slow signals. To third order in x =
// f / cut-off, it is -x^3 / (3 sin(67.5 deg)).
TEST(SensorSampling, AFilterPassesSlowMotionWithoutDelay) {
  constexpr double kSlow_hz = 8.0, kFilter_hz = 25.0;
  const std::complex<double> open =
      ForceAt(FlySampled(kSlow_hz, ImuSampling::kInstantaneous, {}), kSlow_hz);
  const std::complex<double> filtered =
      ForceAt(FlySampled(kSlow_hz, ImuSampling::kInstantaneous, kFilter_hz), kSlow_hz);
  EXPECT_NEAR(std::abs(filtered / open), 1.0, 1e-3);
  // A delay of 1 ms would turn the phase by 0.05.
  EXPECT_NEAR(std::arg(filtered / open), -std::pow(kSlow_hz / kFilter_hz, 3) / 3.0 / 0.9239, 4e-3);
}

TEST(SensorSampling, AFilterActsOnMeansToo) {
  constexpr double kShaken_hz = 80.0;
  const SimulatedFlight flight = FlySampled(kShaken_hz, ImuSampling::kMean, 25.0);
  EXPECT_TRUE(flight.imu_rows.empty());
  double largest_mps2 = 0.0;
  for (const ImuSample& sample : flight.flight.imu->samples) {
    const double t_s = sample.t_s - 0.5 * sample.dt_s;
    if (t_s < flight.strips[0].t0_s + 1.0 || t_s > flight.strips[0].t1_s - 1.0) continue;
    largest_mps2 = std::max(largest_mps2, std::abs(sample.f_b_mps2.norm() - 9.81));
  }
  EXPECT_LT(largest_mps2, 0.02);  // without a filter 0.17: the mean over 10 ms of 80 Hz
}

}  // namespace dn::sim_test
