#include "inertial_noise.h"

#include <dn/sim/simulate.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "network_fit.h"
#include "network_source.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using testing::AircraftScenario;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kNameable = 4.0;  // smallest evidence of an effect that is named, nats

Flight Shaken(const VibrationScenario& vibration, const std::string& effects = "") {
  Scenario scenario = AircraftScenario(effects);
  scenario.plan.vibration = vibration;
  return Simulate(scenario, {}).flight;
}

PreintegrationNoise Part(const ImuModel& model, bool gyro, bool accel) {
  PreintegrationNoise part;
  part.position_floor_m = 0.0;
  if (gyro) part.gyro_white_rad_per_sqrt_s = model.gyro.white;
  if (accel) part.accel_white_mps_per_sqrt_s = model.accel.white;
  return part;
}

TEST(InertialShare, PartsMakeUpTheStatedNoise) {
  const Flight flight = Shaken({});
  const GapOptions options;
  const NetworkFit fit = NetworkFitter(flight, options).Fit({});
  const FlightNetwork& network = fit.solution->network();
  const LinearizedNetwork& linearized = fit.solution->linearized();
  const ImuModel& model = flight.config.imu->model;
  const Eigen::VectorXd gyro = InertialShare(network, linearized, Part(model, true, false));
  const Eigen::VectorXd accel = InertialShare(network, linearized, Part(model, false, true));
  const InertialEdge& edge = network.inertial().edges().front();
  const auto rows = linearized.FindRows(edge.id);
  ASSERT_TRUE(rows.has_value());
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(gyro[rows->first + k], 1.0, 1e-9);
  // The rest of the position rows is the floor of the position.
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(gyro[rows->first + k] + accel[rows->first + k], 1.0, 1e-9);
  }
  for (const PairEdge& pair : network.pairs().edges()) {
    const auto of_pair = linearized.FindRows(pair.id);
    EXPECT_TRUE(!of_pair || gyro[of_pair->first] == 0.0);
  }
}

/// Returns the evidence of an effect of the fit without effects.
double LogEvidence(const NetworkFit& fit, const std::string& name) {
  const auto at = std::find_if(fit.effects.begin(), fit.effects.end(),
                               [&](const auto& effect) { return effect.name == name; });
  return at == fit.effects.end() ? 0.0 : at->log_evidence;
}

TEST(InertialNoiseManyRuns, ShakingIsMotionAndNoNoise) {
  for (const std::string& preset : VibrationPresetNames()) {
    SCOPED_TRACE(preset);
    const Flight flight = Shaken(*VibrationPreset(preset));
    GapOptions options;
    options.depth = GapOptions::Depth::kScreen;
    NetworkSource source(flight, options);
    const auto fit = source.Fit({});
    const auto& network_fit = static_cast<const NetworkFit&>(*fit);
    EXPECT_GT(network_fit.raw_only_nats, 100.0);
    for (const char* noise : {"gyro_noise_scale", "accel_noise_scale", "imu_vibration"}) {
      EXPECT_LT(LogEvidence(network_fit, noise), kNameable) << noise;
    }
    EXPECT_GT(source.Measure(*fit, source.Compare(*fit)).p_value, 1e-3);
    EXPECT_THAT(source.Notes(*fit), Contains(HasSubstr("the inertial record shakes")));
  }
}

TEST(InertialNoiseManyRuns, SensorNoiseThatMovesTheResultIsFound) {
  for (const char* name : {"gyro_noise_scale", "accel_noise_scale"}) {
    SCOPED_TRACE(name);
    const Flight flight = Shaken({}, "effects: [{effect: " + std::string(name) + ", value: 3}]");
    const GapOptions options;
    const NetworkFit fit = NetworkFitter(flight, options).Fit({});
    EXPECT_GT(LogEvidence(fit, name), kNameable);
    EXPECT_EQ(fit.effects.front().name, name);
    EXPECT_NEAR(fit.effects.front().estimate[0], 3.0, 0.1);
  }
}

}  // namespace dn::diagnosis_internal
