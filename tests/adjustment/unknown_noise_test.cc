#include <dn/adjustment/adjust.h>
#include <dn/adjustment/stages.h>
#include <dn/adjustment/unknown_noise.h>
#include <dn/diagnosis/solution.h>
#include <dn/imu/unknown_imu.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "testing/expect_invalid.h"
#include "testing/short_flights.h"

namespace dn::adjustment_test {

/// A simulated flight whose configuration does not state the noise of its inertial unit.
SimulatedFlight FlyUnknown(const Scenario& scenario, unsigned seed) {
  SimulatedFlight sim = testing::Fly(scenario, seed);
  sim.flight.config.imu->grade = kUnknownGrade;
  sim.flight.config.imu->model = UnknownImu();
  return sim;
}

std::map<std::string, NoiseSize> ByName(const NoiseSizes& noise) {
  std::map<std::string, NoiseSize> sizes;
  for (const NoiseSize& size : noise.sizes) sizes[size.name] = size;
  return sizes;
}

// The unknown unit is assumed to be a thousand times worse than one of the two true ones.
class UnknownNoiseManyRuns : public ::testing::TestWithParam<bool> {
 protected:
  static Scenario MakeScenario() {
    return GetParam() ? testing::AircraftScenario() : testing::DroneScenario();
  }
};

TEST_P(UnknownNoiseManyRuns, IsFoundFromTheData) {
  SimulatedFlight sim = FlyUnknown(MakeScenario(), 3);
  const NoiseSizes noise = EstimateNoise({}, &sim.flight);
  EXPECT_TRUE(noise.converged);
  const auto sizes = ByName(noise);
  const ImuModel& truth = MakeScenario().imu.model;
  const double gyro_si = RadPerSqrtSFromDegPerSqrtHour(sizes.at("imu.gyro.white").value);
  const double accel_si = MpsPerSqrtSFromMpsPerSqrtHour(sizes.at("imu.accel.white").value);
  EXPECT_LT(std::abs(std::log(gyro_si / truth.gyro.white)), std::log(1.5));
  EXPECT_LT(std::abs(std::log(accel_si / truth.accel.white)), std::log(1.5));
  EXPECT_NEAR(sizes.at("gnss.sigma_scale").value, 1.0, 0.1);
  EXPECT_DOUBLE_EQ(sim.flight.config.imu->model.gyro.white, gyro_si);
}

TEST_P(UnknownNoiseManyRuns, GivesTheBoresightAnHonestSigma) {
  SimulatedFlight sim = FlyUnknown(MakeScenario(), 3);
  const Solution assumed(sim.flight);
  EstimateNoise({}, &sim.flight);
  const Solution estimated(sim.flight);
  const BoresightResult boresight = estimated.CheckedBoresight();
  EXPECT_EQ(boresight.verdict, Verdict::kCalibrated);
  const Eigen::Vector3d error = boresight.angles_rad - sim.boresight_rad;
  EXPECT_LT(error.cwiseQuotient(boresight.sigma_rad()).cwiseAbs().maxCoeff(), 3.5);
  EXPECT_TRUE(
      (boresight.sigma_rad().array() < assumed.CheckedBoresight().sigma_rad().array()).all());
}

INSTANTIATE_TEST_SUITE_P(Flights, UnknownNoiseManyRuns, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "Aircraft" : "Drone"; });

// GNSS positions that are worse than stated are found, and figures of a data sheet are a start.
TEST(NoiseFromData, GnssSigmasGrowAndStatedFiguresAreTheStart) {
  SimulatedFlight sim =
      FlyUnknown(testing::DroneScenario("effects: [{effect: gnss_noise_scale, value: 2}]\n"), 3);
  sim.flight.config.imu->model.gyro.white = RadPerSqrtSFromDegPerSqrtHour(0.5);
  const auto sizes = ByName(EstimateNoise({}, &sim.flight));
  EXPECT_NEAR(sizes.at("gnss.sigma_scale").value, 2.0, 0.25);
  EXPECT_NEAR(sizes.at("imu.gyro.white").start, 0.5, 1e-12);
}

/// A flight whose GNSS errors are slow, with the sigmas of a single receiver stated for all.
SimulatedFlight FlyWithSlowGnss(unsigned seed) {
  SimulatedFlight sim = FlyUnknown(
      testing::DroneScenario("effects: [{effect: gnss_correlated_noise, value: [1, 1, 2, 40]}]\n"),
      seed);
  sim.flight.config.gnss->sigma_enu_m = {1.0, 1.0, 2.0};
  for (MapGnssEpoch& epoch : sim.flight.gnss->epochs) epoch.covariance_enu_m2.reset();
  return sim;
}

TEST(NoiseFromDataManyRuns, SlowGnssErrorsAreDividedFromWhiteOnes) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    SimulatedFlight sim = FlyWithSlowGnss(seed);
    const NoiseSizes noise = EstimateNoise({}, &sim.flight);
    ASSERT_TRUE(noise.slow_gnss);
    EXPECT_GT(noise.slow_gnss->tau_s, 10.0);
    EXPECT_LT(noise.slow_gnss->tau_s, 80.0);
    const GnssConfig& gnss = *sim.flight.config.gnss;
    ASSERT_EQ(gnss.processes.size(), 1u);
    // Both parts together are the stated errors.
    const Eigen::Vector3d white_m = gnss.sigma_scale * gnss.sigma_enu_m;
    EXPECT_LT(white_m.x(), 0.4);
    EXPECT_NEAR(std::hypot(white_m.x(), gnss.processes[0].sigma_enu_m.x()), 1.0, 0.1);
    EXPECT_TRUE(Adjust(sim.flight).gnss_rejected.empty());
  }
}

TEST(NoiseFromData, SlowGnssErrorsThatTheFlightStatesRemain) {
  SimulatedFlight sim = FlyWithSlowGnss(1);
  const GnssProcess stated{{1.0, 1.0, 2.0}, 40.0};
  sim.flight.config.gnss->processes = {stated};
  EXPECT_FALSE(EstimateNoise({}, &sim.flight).slow_gnss);
  EXPECT_EQ(sim.flight.config.gnss->processes, std::vector<GnssProcess>{stated});
}

TEST(NoiseFromData, WhiteGnssErrorsAreNotDivided) {
  SimulatedFlight sim = FlyUnknown(testing::DroneScenario(), 3);
  EXPECT_FALSE(EstimateNoise({}, &sim.flight).slow_gnss);
  EXPECT_TRUE(sim.flight.config.gnss->processes.empty());
}

// Larger noise would hide the contradiction, and give a wrong clock with a small sigma.
TEST(NoiseFromData, TagsThatAreSecondsLateAreRefusedWithTheirValue) {
  SimulatedFlight sim = FlyUnknown(testing::DroneScenario(), 3);
  for (MapGnssEpoch& epoch : sim.flight.gnss->epochs) epoch.t_s += 10.0;
  try {
    EstimateNoise({}, &sim.flight);
    FAIL() << "no exception";
  } catch (const SensorsContradict& error) {
    const std::string& text = error.finding();
    const std::string before = "the GNSS time tags are ";
    ASSERT_EQ(text.compare(0, before.size(), before), 0) << text;
    EXPECT_NEAR(std::stod(text.substr(before.size())), 10.0, 0.2);
  }
}

TEST(NoiseFromData, PairsThatAreSecondsLateAreRefusedWithTheirValue) {
  const SimulatedFlight sim = testing::Fly(
      testing::DroneScenario("effects: [{effect: lidar_time_offset, value: 10}]\n"), 3);
  testing::ExpectInvalid([&] { Adjust(sim.flight, {}); }, "10 s late", 0);
}

// With the stated noise, the sensors contradict each other. Here this does not end the work.
TEST(NoiseFromDataManyRuns, SensorsThatContradictEachOtherAreTriedWithMore) {
  SimulatedFlight sim = testing::Fly(testing::DroneScenario(), 3);
  sim.flight.config.imu->grade = kUnknownGrade;
  double sign = 1.0;
  for (MapGnssEpoch& epoch : sim.flight.gnss->epochs) epoch.p_m.x() += 1.2 * (sign = -sign);
  EXPECT_THROW(Adjust(sim.flight), SensorsContradict);
  // One axis of three has errors of 80 sigmas.
  const auto sizes = ByName(EstimateNoise({}, &sim.flight));
  EXPECT_NEAR(sizes.at("gnss.sigma_scale").value, 80.0 / std::sqrt(3.0), 8.0);
}

// Taken for noise, this clock makes the gyros several times noisier.
TEST(NoiseFromDataManyRuns, AClockErrorIsNoNoise) {
  SimulatedFlight sim =
      FlyUnknown(testing::DroneScenario("effects: [{effect: gnss_time_offset, value: 0.05}, "
                                        "{effect: gnss_time_drift, value: 200}]\n"),
                 3);
  const auto sizes = ByName(EstimateNoise({}, &sim.flight));
  const double truth = testing::DroneScenario().imu.model.gyro.white;
  const double found = RadPerSqrtSFromDegPerSqrtHour(sizes.at("imu.gyro.white").value);
  EXPECT_LT(std::abs(std::log(found / truth)), std::log(1.5)) << found / truth;
  EXPECT_EQ(sim.flight.config.estimate.size(), 1u);
  const Adjustment adjustment = Adjust(sim.flight);
  ASSERT_TRUE(adjustment.gnss_clock);
  EXPECT_NEAR(adjustment.gnss_clock->offset_s, 0.05, 5.0 * adjustment.gnss_clock->sigma_offset_s);
}

// The accelerometers of this flight show nothing of their white noise.
TEST(NoiseFromDataManyRuns, MayBeTenTimesTheStatedOne) {
  SimulatedFlight sim = testing::Fly(testing::DroneScenario(), 3);
  ImuModel& stated = sim.flight.config.imu->model;
  const double truth = stated.gyro.white;
  stated.gyro.white *= 0.1;
  EstimateNoise({}, &sim.flight);
  EXPECT_NEAR(stated.gyro.white / truth, 1.0, 0.4);
}

// Outliers that the start sizes hide show once the sizes have been found.
TEST(NoiseFromDataManyRuns, OutliersAreNoNoiseAndTheFlightIsAlignedOnce) {
  SimulatedFlight sim = FlyUnknown(testing::DroneScenario(), 3);
  std::vector<MapGnssEpoch>& epochs = sim.flight.gnss->epochs;
  for (std::size_t k = 20; k < epochs.size(); k += 60) epochs[k].p_m.y() += 0.3;
  int alignments = 0;
  AdjustOptions options;
  options.progress = [&](const std::string& stage, int) {
    if (stage == "alignment") ++alignments;
  };
  const NoiseSizes noise = EstimateNoise(options, &sim.flight);
  EXPECT_TRUE(noise.converged);
  EXPECT_NEAR(ByName(noise).at("gnss.sigma_scale").value, 1.0, 0.1);
  EXPECT_EQ(alignments, 1);
}

TEST(NoiseFromDataManyRuns, VelocitiesHaveTheirOwnScale) {
  Scenario scenario = testing::DroneScenario();
  scenario.gnss.velocity = true;
  SimulatedFlight sim = FlyUnknown(scenario, 3);
  for (MapGnssEpoch& epoch : sim.flight.gnss->epochs) *epoch.velocity_covariance_enu /= 9.0;
  const auto sizes = ByName(EstimateNoise({}, &sim.flight));
  EXPECT_NEAR(sizes.at("gnss.sigma_scale").value, 1.0, 0.1);
  EXPECT_NEAR(sizes.at("gnss.velocity_sigma_scale").value, 3.0, 0.4);
  EXPECT_EQ(sim.flight.config.gnss->velocity_sigma_scale,
            sizes.at("gnss.velocity_sigma_scale").value);
}

// Sizes that the adjustment does not accept are no reason to refuse the flight.
TEST(NoiseFromDataManyRuns, ARoundThatFailsEndsWithTheSizesBefore) {
  SimulatedFlight sim = FlyUnknown(testing::DroneScenario(), 3);
  int rounds = 0;
  AdjustOptions options;
  options.with_pairs = false;
  options.stages = DefaultStages(false);
  options.stages.push_back({"last", [&](AdjustmentRun&) {
                              if (++rounds > 2) throw NotConverged("the third round");
                            }});
  const NoiseSizes noise = EstimateNoise(options, &sim.flight);
  EXPECT_EQ(rounds, 3);
  EXPECT_FALSE(noise.converged);
  for (const NoiseSize& size : noise.sizes) {
    EXPECT_NEAR(size.value, size.start, 0.5 * size.start) << size.name;
  }
}

TEST(NoiseFromData, IsThatOfFlightsWithoutDataSheet) {
  SimulatedFlight sim = testing::Fly(testing::DroneScenario(), 3);
  EXPECT_FALSE(HasUnknownNoise(sim.flight.config));
  sim.flight.config.imu->grade = kUnknownGrade;
  EXPECT_TRUE(HasUnknownNoise(sim.flight.config));
}

}  // namespace dn::adjustment_test
