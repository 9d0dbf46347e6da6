#include <dn/diagnosis/adapt.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "diagnosis/simulate_drone.h"
#include "testing/expect_invalid.h"
#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::diagnosis_test {

using testing::Calibration;
using testing::DroneScenario;
using ::testing::HasSubstr;
using testing::kSigmas;
using testing::SimulateDrone;
using ::testing::StartsWith;

constexpr double kRelative = 1e-12;  // roundings
constexpr double kDeg = std::numbers::pi / 180.0;

const Flight& PlainDrone() {
  static const Flight flight = SimulateDrone();
  return flight;
}

/// Returns an effect of its typical size.
GapCause Usual(const EffectSpec& spec) {
  GapCause cause;
  cause.effect = spec.name;
  cause.estimate.resize(static_cast<Eigen::Index>(spec.components.size()));
  for (std::size_t i = 0; i < spec.components.size(); ++i) {
    cause.estimate[static_cast<Eigen::Index>(i)] = spec.components[i].typical;
  }
  if (spec.timing == EffectTiming::kWindow) cause.times.window_s = {381050.0, 381060.0};
  if (spec.timing == EffectTiming::kStart) cause.times.t0_s = 381100.0;
  return cause;
}

GapCause Cause(const std::string& effect, const std::vector<double>& estimate) {
  GapCause cause = Usual(*FindEffect(effect));
  cause.estimate = Eigen::Map<const Eigen::VectorXd>(estimate.data(),
                                                     static_cast<Eigen::Index>(estimate.size()));
  return cause;
}

class EveryEffect : public ::testing::TestWithParam<EffectSpec> {};

TEST_P(EveryEffect, IsReadBackFromTheAdaptedFlight) {
  const std::string before = FormatFlightConfig(PlainDrone().config);
  const std::string after = FormatFlightConfig(Adapted(PlainDrone(), {Usual(GetParam())}));
  const bool fault = GetParam().kind == EffectKind::kFault;
  EXPECT_EQ(after == before, fault);
  EXPECT_EQ(AdaptedKey(GetParam().name).empty(), fault);
  EXPECT_EQ(FormatFlightConfig(ParseFlightConfig(after, "/f")), after);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryEffect, ::testing::ValuesIn(EffectTable()),
                         [](const auto& test) { return test.param.name; });

TEST(Adapted, FixedEffectsAreFreeUnknowns) {
  const FlightConfig config = Adapted(
      PlainDrone(), {Cause("lidar_time_offset", {1e-3}), Cause("boresight_step", {1, 2, 3})});
  ASSERT_EQ(config.estimate.size(), 3u);
  EXPECT_EQ(config.estimate[0].unknown, "boresight");
  EXPECT_EQ(config.estimate[1].unknown, "lidar_time_offset");
  EXPECT_TRUE(config.estimate[1].sigma.empty());
  EXPECT_EQ(config.estimate[2].times.t0_s, 381100.0);
}

TEST(Adapted, WhatWouldLeaveTheStartTooLooseHasAWidePrior) {
  const auto sigma = [](const GapCause& cause) {
    return Adapted(PlainDrone(), {cause}).estimate.back().sigma;
  };
  EXPECT_THAT(sigma(Cause("gravity_tilt", {5, -7})), ::testing::ElementsAre(60.0));
  EXPECT_THAT(sigma(Cause("gravity_tilt", {5, -70})), ::testing::ElementsAre(210.0));
  EXPECT_THAT(sigma(Cause("accel_scale_factor", {1, 1, 1})), ::testing::ElementsAre(2000.0));
  EXPECT_THAT(sigma(Cause("accel_misalignment", {1, 1, 1})), ::testing::ElementsAre(3.0));
  EXPECT_THAT(sigma(Cause("gravity_disturbance", {1})), ::testing::ElementsAre(200.0));
}

TEST(Adapted, DoublesNoUnknownAndChangesNoLossThatWasChosen) {
  Flight flight = PlainDrone();
  flight.config.estimate.push_back({.unknown = "gnss_lever_arm", .sigma = {0.05}});
  flight.config.lidar->robust = RobustKind::kHuber;
  const FlightConfig config =
      Adapted(flight, {Cause("gnss_lever_arm", {1, 2, 3}), Cause("p2p_outliers", {0.1, 1.0})});
  ASSERT_EQ(config.estimate.size(), 2u);
  EXPECT_EQ(config.estimate[1].sigma, std::vector<double>{0.05});
  EXPECT_EQ(config.lidar->robust, RobustKind::kHuber);
}

TEST(Adapted, GnssNoiseScalesVelocitiesWithTheirOwnScale) {
  Flight flight = PlainDrone();
  flight.config.gnss->velocity_sigma_scale = 2.0;
  const FlightConfig config = Adapted(flight, {Cause("gnss_noise_scale", {1.5})});
  EXPECT_EQ(config.gnss->velocity_sigma_scale, 3.0);
}

TEST(Adapted, StatesRandomEffectsInTheNoise) {
  const FlightConfig before = PlainDrone().config;
  const FlightConfig gnss =
      Adapted(PlainDrone(), {Cause("gnss_correlated_noise", {0.01, 0.02, 0.03, 50}),
                             Cause("gnss_noise_scale", {1.5}), Cause("gnss_outliers", {0.1, 1})});
  ASSERT_EQ(gnss.gnss->processes.size(), 1u);
  EXPECT_EQ(gnss.gnss->processes[0], (GnssProcess{{0.01, 0.02, 0.03}, 50.0}));
  EXPECT_EQ(gnss.gnss->sigma_scale, 1.5);
  EXPECT_EQ(gnss.gnss->velocity_sigma_scale, std::nullopt);
  EXPECT_EQ(gnss.gnss->robust, RobustKind::kHuber);

  const FlightConfig by_bank =
      Adapted(PlainDrone(), {Cause("gnss_correlated_noise", {0.01, 0.02, 0.03, 50}),
                             Cause("gnss_multipath", {0.03, 0.02, 0.01, 20})});
  ASSERT_EQ(by_bank.gnss->processes.size(), 2u);
  EXPECT_EQ(by_bank.gnss->processes[0].growth, GnssErrorGrowth::kNone);
  EXPECT_EQ(by_bank.gnss->processes[1],
            (GnssProcess{{0.03, 0.02, 0.01}, 20.0, GnssErrorGrowth::kBank}));
  EXPECT_EQ(AdaptedKey("gnss_multipath"), "gnss.processes");

  const FlightConfig imu =
      Adapted(PlainDrone(), {Cause("gyro_noise_scale", {2.0}), Cause("accel_noise_scale", {3.0}),
                             Cause("gyro_bias_process", {0.3, 90.0})});
  const SensorNoise& gyro = imu.imu->model.gyro;
  EXPECT_EQ(gyro.white, 2.0 * before.imu->model.gyro.white);
  EXPECT_EQ(imu.imu->model.accel.white, 3.0 * before.imu->model.accel.white);
  ASSERT_EQ(gyro.processes.size(), before.imu->model.gyro.processes.size() + 1);
  EXPECT_NEAR(gyro.processes.back().sigma, 0.3 * kDeg / 3600.0, kRelative * kDeg);
  EXPECT_EQ(gyro.processes.back().tau_s, 90.0);

  const FlightConfig pairs = Adapted(PlainDrone(), {Cause("p2p_noise_scale", {2.0})});
  EXPECT_EQ(pairs.lidar->sigma_p_m, 2.0 * before.lidar->sigma_p_m);
}

TEST(Adapted, CoversVibrationAndNoiseThatGrowsWithRange) {
  const FlightConfig before = PlainDrone().config;
  const FlightConfig config =
      Adapted(PlainDrone(), {Cause("imu_vibration", {0.1, 0.3}), Cause("p2p_range_noise", {0.5})});
  EXPECT_EQ(config.imu->model.gyro.white, before.imu->model.gyro.white);
  ASSERT_EQ(config.imu->model.vibration.size(), 1u);
  const ImuVibration& vibration = config.imu->model.vibration[0];
  EXPECT_EQ(vibration.t0_s, 381050.0);
  EXPECT_EQ(vibration.t1_s, 381060.0);
  EXPECT_NEAR(vibration.gyro_sigma_radps, 0.1 * kDeg, kRelative);
  EXPECT_NEAR(vibration.accel_sigma_mps2, 0.3, kRelative);
  const double at_mean_range_m = 0.5e-3 * MeanRange(PlainDrone().pairs->pairs);
  EXPECT_NEAR(config.lidar->sigma_p_m, std::hypot(before.lidar->sigma_p_m, at_mean_range_m),
              kRelative);
}

TEST(Adapted, SaysWhatCannotBe) {
  using testing::InvalidInputLocation;
  InvalidInputLocation([] { Adapted(PlainDrone(), {Cause("gnss_noise_scale", {std::nan("")})}); },
                       "gnss_noise_scale");
  InvalidInputLocation(
      [] {
        Adapted(PlainDrone(), {Cause("gnss_noise_scale", {1.0, 2.0})});
      },
      "takes 1 number");
  Flight without = PlainDrone();
  without.config.lidar.reset();
  InvalidInputLocation([&] { Adapted(without, {Cause("p2p_noise_scale", {2.0})}); }, "'lidar'");
  GapCause unknown;
  unknown.effect = "moonlight";
  InvalidInputLocation([&] { Adapted(PlainDrone(), {unknown}); }, "'moonlight'");
}

TEST(Adapted, AProcessOfNoSizeIsNone) {
  const auto text = [](const FlightConfig& config) { return FormatFlightConfig(config); };
  const std::string before = text(PlainDrone().config);
  EXPECT_EQ(text(Adapted(PlainDrone(), {Cause("gyro_bias_process", {-0.1, 100})})), before);
  EXPECT_EQ(text(Adapted(PlainDrone(), {Cause("gnss_correlated_noise", {0, -0.1, 0, 9})})), before);
  EXPECT_EQ(text(Adapted(PlainDrone(), {Cause("gnss_multipath", {0, -0.1, 0, 9})})), before);
  const FlightConfig one =
      Adapted(PlainDrone(), {Cause("gnss_correlated_noise", {0.1, -0.1, 0, 9})});
  EXPECT_EQ(one.gnss->processes[0].sigma_enu_m, Eigen::Vector3d(0.1, 0, 0));
}

TEST(Adapted, TakesTheCausesOfTheVerdictInItsOrder) {
  GapDiagnosis diagnosis;
  diagnosis.causes = {Cause("lidar_time_offset", {1}), Cause("gnss_lever_arm", {1, 2, 3}),
                      Cause("gyro_noise_scale", {2})};
  diagnosis.verdict.effects = {"gyro_noise_scale", "lidar_time_offset"};
  const std::vector<GapCause> named = VerdictCauses(diagnosis);
  ASSERT_EQ(named.size(), 2u);
  EXPECT_EQ(named[0].effect, "gyro_noise_scale");
  EXPECT_EQ(named[1].effect, "lidar_time_offset");
}

TEST(Adapted, CarriesWhatNothingExplains) {
  GapDiagnosis diagnosis;
  diagnosis.p_value = 0.002;
  diagnosis.where = {{"lidar", "p2p", "strip pair 1-2", 8.5, 0.001}};
  diagnosis.causes = {Cause("gyro_noise_scale", {2})};
  diagnosis.verdict.effects = {"gyro_noise_scale"};
  Flight flight = PlainDrone();
  flight.config.unexplained = "of an earlier diagnosis";
  EXPECT_EQ(Adapted(flight, diagnosis).unexplained, "");
  diagnosis.verdict.unknown = true;
  EXPECT_EQ(Adapted(flight, diagnosis).unexplained,
            "a part of a gap (p = 0.002), mostly in lidar p2p, strip pair 1-2");
  diagnosis.verdict.effects.clear();
  EXPECT_THAT(Adapted(flight, diagnosis).unexplained, StartsWith("all of a gap"));
}

TEST(Adapted, IsReadBackHoweverMuchThereIsToSay) {
  GapDiagnosis diagnosis;
  diagnosis.verdict.unknown = true;
  const std::string name(100, 'n');  // the longest name that a strip may have
  diagnosis.where = {{"accel", "inertial velocity x",
                      "neighbours, strips " + name + "-" + name + ", scan angle 22..37 deg", 8.5,
                      0.001}};
  diagnosis.discrepancies = {{"laser vectors by scan angle", 30.0, 1.0, {}, {}}};
  const FlightConfig adapted = Adapted(PlainDrone(), diagnosis);
  EXPECT_GT(adapted.unexplained.size(), 300u);
  EXPECT_EQ(ParseFlightConfig(FormatFlightConfig(adapted), "/f").unexplained, adapted.unexplained);
}

/// Writes the flight.yaml with these causes in the estimator and reads it back.
Flight Reread(Flight flight, const std::vector<GapCause>& causes) {
  const std::string text = FormatFlightConfig(Adapted(flight, causes));
  flight.config = ParseFlightConfig(text, "/f");
  return flight;
}

TEST(AdaptedFlight, EstimatesTheFixedEffectsThatAreInIt) {
  const std::vector<GapCause> causes{Cause("lidar_time_offset", {0.004}),
                                     Cause("gnss_lever_arm", {0.1, 0.05, -0.08})};
  const Flight flight =
      Reread(SimulateDrone("effects: [{effect: lidar_time_offset, value: 0.004}, "
                           "{effect: gnss_lever_arm, value: [0.1, 0.05, -0.08]}]"),
             causes);
  const Calibration adjusted(flight);
  std::size_t found = 0;
  for (const UnknownEstimate& unknown : adjusted.solution.Unknowns()) {
    const GapCause& cause = unknown.name == "lidar_time_offset" ? causes[0] : causes[1];
    ASSERT_EQ(unknown.name, cause.effect);
    for (std::size_t i = 0; i < unknown.value.size(); ++i, ++found) {
      EXPECT_NEAR(unknown.value[i], cause.estimate[static_cast<Eigen::Index>(i)],
                  kSigmas * unknown.sigma[i])
          << unknown.name;
    }
  }
  EXPECT_EQ(found, 4u);
}

TEST(AdaptedFlight, NoiseThatIsStatedFits) {
  const std::string entry = "effects: [{effect: p2p_noise_scale, value: 3}]";
  const Flight bare = SimulateDrone(entry);
  const Flight flight = Reread(bare, {Cause("p2p_noise_scale", {3.0})});
  const double without = Solution(bare).trajectory().figures.sigma0;
  const double with = Solution(flight).trajectory().figures.sigma0;
  constexpr double kHardlyAnyOf300Pairs = 0.1;  // sigma0 of 300 pairs and more scatters by 0.02
  EXPECT_GT(without, 1.0 + 2.0 * kHardlyAnyOf300Pairs);
  EXPECT_NEAR(with, 1.0, kHardlyAnyOf300Pairs);
}

/// Fit of a flight to its model.
struct Fit {
  double misfit = 0.0;  ///< chi2 minus its redundancy, in standard deviations
  double nees = 0.0;    ///< NEES of the boresight: chi-square with 3 degrees of freedom
};

Fit AdjustAndFit(const SimulatedFlight& flown, const std::vector<GapCause>& stated) {
  const Flight flight = Reread(flown.flight, stated);
  const Calibration adjusted(flight);
  const AdjustmentFigures& figures = adjusted.solution.trajectory().figures;
  const auto redundancy = static_cast<double>(figures.redundancy);
  const Eigen::Vector3d error = adjusted.BoresightError(flown.boresight_rad);
  return {(figures.chi2 - redundancy) / std::sqrt(2.0 * redundancy),
          error.dot(adjusted.boresight.covariance_rad2.ldlt().solve(error))};
}

// The vibration lasts for the first strip only, where two of the three pairs of strips have an end.
TEST(AdaptedFlightManyRuns, VibrationThatIsStatedInItsWindowFits) {
  constexpr int kFlights = 4;
  const StripInterval strip = PlainDrone().config.strips.at(0);
  GapCause cause = Cause("imu_vibration", {1.0, 0.5});
  cause.times.window_s = {strip.t0_s, strip.t1_s};
  const Scenario scenario = DroneScenario("effects: [{effect: imu_vibration, value: [1.0, 0.5]" +
                                          FormatEffectTimes(cause.times) + "}]");
  double nees_without = 0.0, nees_with = 0.0;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedFlight flown = Simulate(scenario, {.seed = seed});
    const Fit without = AdjustAndFit(flown, {}), with = AdjustAndFit(flown, {cause});
    EXPECT_GT(without.misfit, kSigmas);
    EXPECT_LT(std::abs(with.misfit), kSigmas);
    nees_without += without.nees;
    nees_with += with.nees;
  }
  constexpr double kBound = 37.7;  // chi-square with 12 degrees of freedom exceeds it by 2e-4
  EXPECT_GT(nees_without, kBound);
  EXPECT_LT(nees_with, kBound);
}

}  // namespace dn::diagnosis_test
