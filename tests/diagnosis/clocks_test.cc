// Tests of flights whose GNSS or scanner clock differs from the inertial clock.
#include <dn/adjustment/words.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <vector>

#include "testing/short_flights.h"
#include "testing/strip_pairs.h"
#include "testing/tolerances.h"

namespace dn::diagnosis_test {

using testing::AircraftScenario;
using ::testing::AllOf;
using testing::Calibration;
using testing::DroneScenario;
using ::testing::HasSubstr;
using testing::kSigmas;
using ::testing::Not;

/// A sensor grade, and the clock error of its GNSS receiver.
struct Receiver {
  const char* name;
  double sigma_m;
  double rate_hz;
  double offset_s;
  double drift_ppm;
};

std::string Number(double value) { return std::to_string(value); }

SimulatedFlight FlyWithReceiver(const Receiver& receiver) {
  Scenario scenario =
      DroneScenario("effects: [{effect: gnss_time_offset, value: " + Number(receiver.offset_s) +
                    "}, {effect: gnss_time_drift, value: " + Number(receiver.drift_ppm) + "}]\n");
  scenario.gnss.rate_hz = receiver.rate_hz;
  scenario.gnss.sigma_enu_m = receiver.sigma_m * Eigen::Vector3d(1.0, 1.0, 1.5);
  scenario.gnss.velocity = true;
  SimulateOptions options;
  options.seed = 3;
  return Simulate(scenario, options);
}

void ExpectNear(const ClockEstimate& clock, const Receiver& receiver) {
  EXPECT_NEAR(clock.offset_s, receiver.offset_s, kSigmas * clock.sigma_offset_s);
  EXPECT_NEAR(clock.drift, 1e-6 * receiver.drift_ppm, kSigmas * clock.sigma_drift);
}

class ClockThatIsOff : public ::testing::TestWithParam<Receiver> {};

constexpr auto kReceiverName = [](const auto& tested) { return std::string(tested.param.name); };

INSTANTIATE_TEST_SUITE_P(Receivers, ClockThatIsOff,
                         ::testing::Values(Receiver{"MetresLateAndDrifting", 2.0, 2.0, 0.5,
                                                    -2000.0}),
                         kReceiverName);
INSTANTIATE_TEST_SUITE_P(ManyRuns, ClockThatIsOff,
                         ::testing::Values(Receiver{"CentimetresLate", 0.02, 1.0, 0.25, 0.0},
                                           Receiver{"CentimetresVeryEarly", 0.02, 2.0, -1.0, 0.0},
                                           Receiver{"MetresLate", 2.0, 5.0, 0.25, 0.0},
                                           Receiver{"CentimetresDrifting", 0.02, 1.0, 0.0, 200.0}),
                         kReceiverName);

TEST_P(ClockThatIsOff, IsNamedWithItsSizeAndNoEpochIsLeftOut) {
  const Receiver& receiver = GetParam();
  const SimulatedFlight sim = FlyWithReceiver(receiver);
  const Solution solution(sim.flight);
  EXPECT_TRUE(solution.adjustment().gnss_rejected.empty());
  ASSERT_TRUE(solution.adjustment().gnss_clock);
  const ClockEstimate& clock = *solution.adjustment().gnss_clock;
  ExpectNear(clock, receiver);
  EXPECT_EQ(clock.shows_offset(), receiver.offset_s != 0.0);
  EXPECT_EQ(clock.shows_drift(), receiver.drift_ppm != 0.0);
  const ModelCheck& check = solution.model_check();
  ASSERT_TRUE(check.clocks.gnss);
  EXPECT_EQ(check.clocks.gnss->offset_s, clock.offset_s);
  EXPECT_EQ(solution.CheckedBoresight().verdict, Verdict::kContradicted);
  ASSERT_FALSE(check.findings.empty());
  EXPECT_NE(check.findings.front().As<facts::GnssTimeOff>(), nullptr)
      << Words(check.findings.front());
}

TEST_P(ClockThatIsOff, IsEstimatedWithTheBoresight) {
  const Receiver& receiver = GetParam();
  SimulatedFlight sim = FlyWithReceiver(receiver);
  sim.flight.config.estimate = {{.unknown = "boresight"}, {.unknown = "gnss_time_offset"}};
  if (receiver.drift_ppm != 0.0) {
    sim.flight.config.estimate.push_back({.unknown = "gnss_time_drift"});
  }
  const Calibration c(sim.flight);
  EXPECT_TRUE(c.adjustment.gnss_rejected.empty());
  EXPECT_FALSE(c.adjustment.gnss_clock);
  ASSERT_TRUE(c.solution.model_check().clocks.gnss);
  ExpectNear(*c.solution.model_check().clocks.gnss, receiver);
  EXPECT_TRUE(c.solution.trajectory().warnings.empty());
  const Eigen::Vector3d e = c.BoresightError(sim.boresight_rad);
  EXPECT_LT(e.cwiseQuotient(c.boresight.sigma_rad()).cwiseAbs().maxCoeff(), kSigmas);
  EXPECT_EQ(c.solution.CheckedBoresight().verdict, Verdict::kCalibrated);
}

TEST(Clocks, OfAGoodFlightAreZeroWithinTheirSigmas) {
  const SimulatedFlight sim = FlyWithReceiver({"", 0.02, 1.0, 0.0, 0.0});
  const Solution solution(sim.flight);
  EXPECT_FALSE(solution.adjustment().gnss_clock);
  for (const auto& clock :
       {solution.model_check().clocks.gnss, solution.model_check().clocks.lidar}) {
    ASSERT_TRUE(clock);
    EXPECT_GT(clock->sigma_offset_s, 0.0);
    EXPECT_GT(clock->sigma_drift, 0.0);
    ExpectNear(*clock, {"", 0.0, 0.0, 0.0, 0.0});
  }
}

/// Leap seconds that the tags of the GNSS receiver lack.
class OldLeapSeconds : public ::testing::TestWithParam<double> {};

INSTANTIATE_TEST_SUITE_P(Seconds, OldLeapSeconds, ::testing::Values(-2.0));
INSTANTIATE_TEST_SUITE_P(ManyRuns, OldLeapSeconds, ::testing::Values(-3.0, -1.0, 1.0));

// A clock within 2 s is estimated. Beyond, the adjustment ends, and its message has the value, with
// its sigma.
TEST_P(OldLeapSeconds, AreNamedWithTheirValue) {
  const SimulatedFlight sim = FlyWithReceiver({"", 0.02, 1.0, GetParam(), 0.0});
  double found_s = 0.0, tolerance_s = 0.05;
  AdjustOptions options;
  options.with_pairs = false;
  try {
    const Adjustment adjustment = Adjust(sim.flight, options);
    ASSERT_TRUE(adjustment.gnss_clock);
    found_s = adjustment.gnss_clock->offset_s;
  } catch (const SensorsContradict& error) {
    const std::string text = error.what(), before = "the GNSS time tags are ", between = " +- ";
    ASSERT_THAT(text, AllOf(HasSubstr(before), HasSubstr(between)));
    const std::string late = text.find(" s late") != std::string::npos ? "" : "-";
    found_s = std::stod(late + text.substr(text.find(before) + before.size()));
    tolerance_s = kSigmas * std::stod(text.substr(text.find(between) + between.size()));
  }
  EXPECT_NEAR(found_s, GetParam(), tolerance_s);
  EXPECT_LT(tolerance_s, 0.3);
}

TEST(Clocks, OfTheScannerAreReported) {
  const SimulatedFlight sim = Simulate(
      DroneScenario("effects: [{effect: lidar_time_offset, value: 0.005}]\n"), {.seed = 3});
  const Solution solution(sim.flight);
  const std::optional<ClockEstimate> lidar = solution.model_check().clocks.lidar;
  ASSERT_TRUE(lidar);
  EXPECT_TRUE(lidar->shows_offset());
  EXPECT_NEAR(lidar->offset_s, 0.005, kSigmas * lidar->sigma_offset_s);
  EXPECT_FALSE(solution.model_check().clocks.gnss->shows_offset());
}

// A score test gives 98 ms with a sigma of 0.6 ms: the beam does not move linearly for so long.
TEST(Clocks, FarOffsetsAreNotReportedToFirstOrder) {
  const SimulatedFlight sim =
      Simulate(DroneScenario("effects: [{effect: lidar_time_offset, value: 0.1}]\n"), {.seed = 3});
  const Solution solution(sim.flight);
  EXPECT_FALSE(solution.model_check().clocks.lidar);
  EXPECT_EQ(solution.CheckedBoresight().verdict, Verdict::kContradicted);
}

TEST(Clocks, AreReportedWithSizeSigmaAndKey) {
  const ClockEstimate late{0.25, 1e-4, 1e-7, 1e-7};
  EXPECT_THAT(Words(Finding{facts::GnssTimeOff{late, 93.0, true}}),
              AllOf(HasSubstr("are 0.25 +- 0.0001 s late"), HasSubstr("moves the boresight (93.0"),
                    HasSubstr("estimate gnss_time_offset"), Not(HasSubstr("gnss_time_drift"))));
  const ClockEstimate drifting{1e-5, 1e-4, 2e-4, 1e-7};
  EXPECT_THAT(Words(Finding{facts::GnssTimeOff{drifting, 93.0, false}}),
              AllOf(HasSubstr("drift by 200 +- 0.1 ppm"), HasSubstr("moves the trajectory"),
                    HasSubstr("estimate gnss_time_drift"), Not(HasSubstr("s late"))));
}

// Compares with the conditional normal distribution, computed from the inverse of the covariance.
TEST(Clocks, OneAloneIsTheConditionalEstimate) {
  const ClockEstimate both{1e-3, 2e-4, -3e-6, 1e-6, -0.8};
  Eigen::Matrix2d covariance;
  covariance << 4e-8, -0.8 * 2e-10, -0.8 * 2e-10, 1e-12;
  const Eigen::Matrix2d N = covariance.inverse();
  const Eigen::Vector2d right = N * Eigen::Vector2d(1e-3, -3e-6);
  EXPECT_NEAR(both.WithoutDrift().offset_s, right[0] / N(0, 0), 1e-12);
  EXPECT_NEAR(both.WithoutDrift().sigma_offset_s, std::sqrt(1.0 / N(0, 0)), 1e-12);
  EXPECT_NEAR(both.WithoutOffset().drift, right[1] / N(1, 1), 1e-14);
  EXPECT_NEAR(both.WithoutOffset().sigma_drift, std::sqrt(1.0 / N(1, 1)), 1e-14);
}

/// Position errors of three times the stated white sigma and more, with this correlation time in
/// seconds.
class CorrelatedPositionErrors : public ::testing::TestWithParam<double> {
 protected:
  CorrelatedPositionErrors() {
    const std::string process =
        "{effect: gnss_correlated_noise, value: [0.05, 0.05, 0.1, " + Number(GetParam()) + "]}";
    sim_ = Simulate(AircraftScenario("effects: [" + process + "]\n"), {.seed = 3});
  }
  SimulatedFlight sim_;
};

INSTANTIATE_TEST_SUITE_P(Taus, CorrelatedPositionErrors, ::testing::Values(20.0));
INSTANTIATE_TEST_SUITE_P(ManyRuns, CorrelatedPositionErrors, ::testing::Values(40.0, 120.0));

TEST_P(CorrelatedPositionErrors, AreNotAClockStepAndCostNoEpochs) {
  const Calibration c(sim_.flight);
  EXPECT_LE(c.adjustment.gnss_rejected.size(), 3U);
  EXPECT_FALSE(c.adjustment.gnss_clock);
  EXPECT_TRUE(c.adjustment.gnss_correlation.significant());
}

TEST_P(CorrelatedPositionErrors, ContradictOnlyThePureModelIfTheyAreSlow) {
  const BoresightResult automatic = Solution(sim_.flight).CheckedBoresight();
  // The process that is estimated by default has periods of at least 30 s.
  const bool slow = GetParam() > 30.0;
  EXPECT_EQ(automatic.verdict, slow ? Verdict::kCalibrated : Verdict::kContradicted);
  const Eigen::Vector3d e = testing::BoresightError(automatic.angles_rad, sim_.boresight_rad);
  EXPECT_LT(e.cwiseQuotient(automatic.sigma_rad()).cwiseAbs().maxCoeff(), kSigmas);
  sim_.flight.config.unmodelled.none = true;
  EXPECT_EQ(Solution(sim_.flight).CheckedBoresight().verdict, Verdict::kContradicted);
}

// In these flights, a drifting GNSS clock would explain a part of the errors.
TEST(Clocks, CorrelatedPositionErrorsAreNotADrift) {
  for (const unsigned seed : {5U, 12U}) {
    SCOPED_TRACE(seed);
    const SimulatedFlight sim =
        Simulate(AircraftScenario(
                     "effects: [{effect: gnss_correlated_noise, value: [0.05, 0.05, 0.1, 20]}]\n"),
                 {.seed = seed});
    const Solution solution(sim.flight);
    EXPECT_TRUE(solution.model_check().effects.empty());
    EXPECT_EQ(solution.CheckedBoresight().verdict, Verdict::kContradicted);
  }
}

TEST_P(CorrelatedPositionErrors, AreScreenedWithTheirProcess) {
  sim_.flight.config.gnss->processes = {{{0.05, 0.05, 0.1}, GetParam()}};
  const Calibration c(sim_.flight);
  EXPECT_TRUE(c.adjustment.gnss_rejected.empty());
  EXPECT_FALSE(c.adjustment.gnss_clock);
  const Eigen::Vector3d e = c.BoresightError(sim_.boresight_rad);
  EXPECT_LT(e.cwiseQuotient(c.boresight.sigma_rad()).cwiseAbs().maxCoeff(), kSigmas);
  EXPECT_EQ(c.solution.CheckedBoresight().verdict, Verdict::kCalibrated);
}

}  // namespace dn::diagnosis_test
