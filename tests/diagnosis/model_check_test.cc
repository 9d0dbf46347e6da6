#include <dn/adjustment/words.h>
#include <dn/diagnosis/model_check.h>
#include <dn/effects/effect_table.h>
#include <dn/rotation.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "network_hypotheses.h"
#include "testing/short_flights.h"
#include "testing/torsion.h"

namespace dn::diagnosis_test {

using testing::AircraftScenario;
using testing::Calibration;
using testing::DroneScenario;
using testing::Fly;
using ::testing::HasSubstr;

/// An adjusted and checked flight, without effects outside of the model.
struct Checked {
  SimulatedFlight simulated;
  Calibration calibration;
  TrajectoryResult trajectory;
  ModelCheck check;

  explicit Checked(SimulatedFlight flight, const AdjustOptions& options = {})
      : simulated(Pure(std::move(flight))),
        calibration(simulated.flight, options),
        trajectory(calibration.solution.trajectory()),
        check(calibration.solution.model_check()) {
    Assess(check, &calibration.boresight);
  }

  static SimulatedFlight Pure(SimulatedFlight flight) {
    flight.flight.config.unmodelled.none = true;
    return flight;
  }

  const BoresightResult& boresight() const { return calibration.boresight; }
  std::string first_reason() const { return Words(boresight().reasons.front()); }
};

TEST(ModelCheck, IsConsistentUntilAFindingContradicts) {
  ModelCheck check;
  check.findings.push_back({facts::GnssLeftOut{0.2}});
  EXPECT_STREQ(Word(check), "consistent");
  check.findings.push_back({facts::UpsideDown{}, true});
  EXPECT_STREQ(Word(check), "contradicted");
}

TEST(ModelCheck, FindingsComeFirstAndOnce) {
  ModelCheck check;
  check.findings.push_back({facts::GnssTimeOff{{0.05, 0.001}}, true});
  BoresightResult boresight;
  boresight.verdict = Verdict::kAbsorbed;
  boresight.reasons.push_back({facts::GnssTimeOff{{0.05, 0.001}}, true});
  boresight.reasons.push_back({facts::FewPairs{12}});
  Assess(check, &boresight);
  EXPECT_EQ(boresight.verdict, Verdict::kContradicted);
  EXPECT_THAT(Words(boresight.reasons),
              ElementsAre(HasSubstr("are 0.05 +- 0.001 s late"), HasSubstr("only 12 pairs")));
}

TEST(ModelCheckManyRuns, FlightsOfTheirOwnModelAreNotContradicted) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const Scenario& scenario : {AircraftScenario(), DroneScenario()}) {
      const Checked flight(Fly(scenario, seed));
      EXPECT_EQ(flight.boresight().verdict, Verdict::kCalibrated) << flight.first_reason();
      EXPECT_TRUE(flight.check.effects.empty());
      EXPECT_GT(flight.check.p_value, 1e-3);
    }
  }
}

// Adds an undetectable effect of its typical size to the data. It shifts the boresight as
// predicted, and the verdict does not change.
TEST(ModelCheck, UndetectableEffectsShiftAsPredicted) {
  const Checked without(Fly(AircraftScenario(), 3));
  ASSERT_FALSE(without.check.undetectable.empty());
  const UndetectableEffect& worst = without.check.undetectable.front();
  EXPECT_GT(worst.max_shift_sigmas, 1.0);
  EXPECT_GT(worst.minimal_detectable, worst.usual);
  const EffectSpec& spec = *FindEffect(worst.name);
  std::string value;
  for (const EffectComponent& component : spec.components) {
    const bool is_it = spec.components.size() == 1 || component.name == worst.component;
    value += (value.empty() ? "[" : ", ") + std::to_string(is_it ? worst.usual : 0.0);
  }
  const Checked with(
      Fly(AircraftScenario("effects: [{effect: " + worst.name + ", value: " + value + "]}]\n"), 3));
  EXPECT_EQ(with.boresight().verdict, Verdict::kCalibrated) << with.first_reason();
  const Eigen::Vector3d moved_rad = with.boresight().angles_rad - without.boresight().angles_rad;
  EXPECT_LE((moved_rad - worst.boresight_rad).norm(), 0.1 * worst.boresight_rad.norm());
  EXPECT_GT(moved_rad.cwiseQuotient(without.boresight().sigma_rad()).cwiseAbs().maxCoeff(), 0.9);
}

TEST(ModelCheckManyRuns, UndetectableEffectsDoNotDependOnTheData) {
  const Checked one(Fly(AircraftScenario(), 3));
  for (std::size_t k = 1; k < one.check.undetectable.size(); ++k) {
    EXPECT_GE(one.check.undetectable[k - 1].max_shift_sigmas,
              one.check.undetectable[k].max_shift_sigmas);
    EXPECT_NE(one.check.undetectable[k - 1].name, one.check.undetectable[k].name);
  }
  SimulatedFlight simulated = Fly(AircraftScenario(), 3);
  simulated.flight.config.estimate.push_back({.unknown = one.check.undetectable[0].name});
  const Checked estimated(std::move(simulated));
  for (const UndetectableEffect& undetectable : estimated.check.undetectable) {
    EXPECT_NE(undetectable.name, one.check.undetectable[0].name)
        << "an estimated unknown is detectable";
  }
}

TEST(ModelCheck, RedundanciesOfTheGroupsAddUp) {
  const Checked flight(Fly(AircraftScenario(), 2));
  double redundancy = 0.0;
  for (const GroupCheck& group : flight.check.groups) {
    EXPECT_GT(group.observations, 0) << group.name;
    EXPECT_GE(group.redundancy, 0.0) << group.name;
    for (const char* whole : {"lidar p2p", "gnss position", "inertial gyro", "inertial velocity",
                              "inertial position", "gyro bias process", "accel bias process"}) {
      if (group.name == whole) redundancy += group.redundancy;
    }
  }
  // The priors of the initial biases have the remaining redundancy.
  const auto all = static_cast<double>(flight.trajectory.figures.redundancy);
  EXPECT_LE(redundancy, all + 1e-3);
  EXPECT_GT(redundancy, all - 20.0);
}

struct Injection {
  std::string effect;
  std::string value;
  std::vector<double> components;  ///< in the effect's unit
  bool aircraft;
  double tolerance;  ///< relative, for the first-order score test
};

std::ostream& operator<<(std::ostream& out, const Injection& injection) {
  return out << injection.effect << " " << injection.value;
}

std::string InjectionEffects(const Injection& injection) {
  return "effects: [{effect: " + injection.effect + ", value: " + injection.value + "}]\n";
}

Scenario InjectionScenario(const Injection& injection, const std::string& extra) {
  return injection.aircraft ? AircraftScenario(extra) : DroneScenario(extra);
}

/// Returns the estimate of one effect alone.
Eigen::VectorXd EstimateEffect(const std::string& name, const Checked& flight) {
  const FlightNetwork& network = *flight.calibration.adjustment.network;
  const diagnosis_internal::Library library = diagnosis_internal::MakeNetworkHypotheses(network);
  for (const diagnosis_internal::Hypothesis& hypothesis : library.hypotheses) {
    if (hypothesis.name != name) continue;
    return hypothesis.per_si *
           TestEffects(flight.calibration.marginals, {library.blocks[hypothesis.block]})
               .front()
               .estimate;
  }
  ADD_FAILURE() << "no hypothesis " << name;
  return {};
}

class InjectedEffect : public ::testing::TestWithParam<Injection> {};

// Two flights have the same noise, with and without the effect. The difference of the estimates is
// then the effect, and that of the boresights is its shift. The simulator shares no formula with
// the tested derivative.
TEST_P(InjectedEffect, IsEstimatedNamedAndItsShiftPredicted) {
  const Injection& injection = GetParam();
  const Checked without(Fly(InjectionScenario(injection, ""), 5));
  const Checked with(Fly(InjectionScenario(injection, InjectionEffects(injection)), 5));
  const Eigen::Map<const Eigen::VectorXd> injected(
      injection.components.data(), static_cast<Eigen::Index>(injection.components.size()));
  const Eigen::VectorXd found =
      EstimateEffect(injection.effect, with) - EstimateEffect(injection.effect, without);
  EXPECT_LT((found - injected).norm(), injection.tolerance * injected.norm()) << found.transpose();

  ASSERT_FALSE(with.check.effects.empty());
  const EffectCheck& first = with.check.effects.front();
  std::vector<std::string> named = first.inseparable_from;
  named.push_back(first.name);
  EXPECT_THAT(named, ::testing::Contains(injection.effect));
  const Eigen::Vector3d moved = Log(Eigen::Quaterniond(
      Exp(with.boresight().angles_rad) * Exp(without.boresight().angles_rad).conjugate()));
  if (first.name == injection.effect) {
    const Eigen::Vector3d sigma = with.boresight().sigma_rad();
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(first.boresight_rad[i], moved[i], 3.0 * sigma[i] + 0.15 * moved.norm()) << i;
    }
  }
  if (moved.cwiseQuotient(without.boresight().sigma_rad()).cwiseAbs().maxCoeff() > 4.0) {
    EXPECT_EQ(with.boresight().verdict, Verdict::kContradicted);
  }
}

constexpr auto kInjectionName = [](const auto& tested) { return tested.param.effect; };

INSTANTIATE_TEST_SUITE_P(
    ModelCheck, InjectedEffect,
    ::testing::Values(Injection{"lidar_time_offset", "0.01", {0.01}, false, 0.03},
                      Injection{
                          "accel_scale_factor", "[0, 0, 500]", {0.0, 0.0, 500.0}, true, 0.25}),
    kInjectionName);

INSTANTIATE_TEST_SUITE_P(
    ManyRuns, InjectedEffect,
    ::testing::Values(
        Injection{"lidar_lever_arm", "[0.2, -0.1, 0.3]", {0.2, -0.1, 0.3}, false, 0.05},
        Injection{"lidar_time_drift", "20", {20.0}, true, 0.05},
        Injection{"lidar_range_offset", "0.2", {0.2}, true, 0.05},
        Injection{"lidar_range_scale", "2000", {2000.0}, true, 0.05},
        Injection{"lidar_angle_scale", "3000", {3000.0}, true, 0.05},
        Injection{"gnss_lever_arm", "[0.1, -0.1, 0.1]", {0.1, -0.1, 0.1}, false, 0.05},
        Injection{"gnss_time_offset", "0.01", {0.01}, false, 0.05},
        Injection{"gnss_time_drift", "20", {20.0}, false, 0.05},
        Injection{"gyro_scale_factor", "[60, -60, 60]", {60.0, -60.0, 60.0}, true, 0.1},
        Injection{"gyro_misalignment", "[0.5, 0.4, -0.3]", {0.5, 0.4, -0.3}, true, 0.25},
        Injection{"gyro_g_sensitivity", "[0.15, 0.15, 0.15]", {0.15, 0.15, 0.15}, true, 0.25},
        Injection{"gravity_tilt", "[10, -10]", {10.0, -10.0}, true, 0.25}),
    kInjectionName);

Checked CheckedWithUnknown(const std::string& effects, EstimateEntry unknown) {
  SimulatedFlight simulated = Fly(AircraftScenario(effects), 5);
  simulated.flight.config.estimate.push_back(std::move(unknown));
  return Checked(std::move(simulated));
}

// A common rotation of both triads equals a rotation of the body. The estimated misalignment may
// therefore be the other one, with another boresight. The check predicts the boresight of a flight
// that estimates the competing effect.
TEST(ModelCheck, AnUnknownWithACompetingEffectIsNotObservable) {
  const std::string turned = "effects: [{effect: accel_misalignment, value: [0.5, -0.4, 0.3]}]\n";
  const Checked by_gyro = CheckedWithUnknown(turned, {.unknown = "gyro_misalignment"});
  const Checked by_accel =
      CheckedWithUnknown(turned, {.unknown = "accel_misalignment", .sigma = {3.0}});
  EXPECT_EQ(by_gyro.boresight().verdict, Verdict::kNotObservable);
  ASSERT_EQ(by_gyro.check.competing_effects.size(), 1u);
  const CompetingEffectCheck& competing = by_gyro.check.competing_effects.front();
  EXPECT_EQ(competing.unknown, "gyro_misalignment");
  EXPECT_EQ(competing.competing_effect, "accel_misalignment");
  const Eigen::Vector3d moved = Log(Eigen::Quaterniond(
      Exp(by_accel.boresight().angles_rad) * Exp(by_gyro.boresight().angles_rad).conjugate()));
  EXPECT_GT(moved.norm(), 0.02 * kRadPerDeg);
  EXPECT_LT((competing.boresight_rad - moved).norm(), 0.05 * moved.norm()) << moved.transpose();
  EXPECT_EQ(Words(by_gyro.boresight().reasons).front(), by_gyro.first_reason());
  EXPECT_THAT(by_gyro.first_reason(), HasSubstr("accel_misalignment instead of"));
}

TEST(ModelCheckManyRuns, AnUnknownByItselfIsCalibrated) {
  const std::string late = "effects: [{effect: gnss_lever_arm, value: [0.3, -0.2, 0.2]}]\n";
  const Checked flight = CheckedWithUnknown(late, {.unknown = "gnss_lever_arm"});
  EXPECT_TRUE(flight.check.competing_effects.empty() ||
              flight.check.competing_effects.front().max_shift_sigmas <= 1.0);
  EXPECT_EQ(flight.boresight().verdict, Verdict::kCalibrated) << flight.first_reason();
}

TEST(ModelCheck, APriorThatContradictsIsNamedWithItsKey) {
  SimulatedFlight simulated = Fly(AircraftScenario(), 3);
  simulated.flight.config.lidar->boresight_sigma_rad =
      // About zero; the truth is 0.2, 0.03, 0.35 deg.
      Eigen::Vector3d::Constant(0.01 * kRadPerDeg);
  const Checked flight(std::move(simulated));
  EXPECT_EQ(flight.boresight().verdict, Verdict::kContradicted);
  EXPECT_THAT(flight.first_reason(), HasSubstr("lidar.boresight_sigma_deg"));
}

TEST(ModelCheckManyRuns, AnHonestPriorIsNot) {
  SimulatedFlight simulated = Fly(AircraftScenario(), 3);
  simulated.flight.config.lidar->boresight_sigma_rad = Eigen::Vector3d::Constant(kRadPerDeg);
  EXPECT_EQ(Checked(std::move(simulated)).boresight().verdict, Verdict::kCalibrated);
}

TEST(ModelCheck, AnUnexplainedDiagnosisContradicts) {
  SimulatedFlight simulated = Fly(DroneScenario(), 3);
  simulated.flight.config.unexplained = "a part of a gap (p = 0.002)";
  const Checked flight(std::move(simulated));
  EXPECT_EQ(flight.boresight().verdict, Verdict::kContradicted);
  EXPECT_THAT(flight.first_reason(), HasSubstr("a part of a gap (p = 0.002)"));
}

TEST(ModelCheck, NoiseOfTwiceItsStatedSigmaIsTooMuch) {
  SimulatedFlight simulated = Fly(DroneScenario(), 4);
  simulated.flight.config.lidar->sigma_p_m *= 0.5;
  const Checked flight(std::move(simulated));
  EXPECT_EQ(flight.boresight().verdict, Verdict::kContradicted);
  EXPECT_THAT(flight.first_reason(), HasSubstr("lidar.sigma_p_m"));
}

TEST(ModelCheckManyRuns, AShiftOfOnePairOfStripsIsFound) {
  SimulatedFlight simulated = Fly(AircraftScenario(), 6);
  for (LidarPair& pair : simulated.flight.pairs->pairs) {
    if (pair.file == 0) pair.u_j_s += Eigen::Vector3d(0.15, 0.1, 0.15);
  }
  const Checked flight(std::move(simulated));
  EXPECT_EQ(flight.boresight().verdict, Verdict::kContradicted) << flight.first_reason();
}

TEST(ModelCheck, ATorsionOfTheScannerIsUnmodelledAndContradicts) {
  const Checked without(Fly(AircraftScenario(), 3));
  const Checked with(testing::FlyWithTorsion(AircraftScenario(), 0.02));
  const DiscrepancyCheck& by_angle = with.check.discrepancies.front();
  EXPECT_EQ(by_angle.name, "laser vectors by scan angle");
  EXPECT_LT(by_angle.p_value, 1e-4);
  EXPECT_GT(without.check.discrepancies.front().p_value, 0.1);
  const Finding* unnamed = nullptr;
  for (const Finding& finding : with.check.findings) {
    if (finding.As<facts::UnmodelledDiscrepancy>() != nullptr) unnamed = &finding;
  }
  ASSERT_NE(unnamed, nullptr);
  EXPECT_TRUE(unnamed->contradicts);
  EXPECT_EQ(with.boresight().verdict, Verdict::kContradicted);
}

TEST(ModelCheck, AFoundEffectLeavesNoDiscrepancy) {
  const Checked flight(
      Fly(AircraftScenario("effects: [{effect: lidar_angle_scale, value: 1500}]\n"), 3));
  ASSERT_FALSE(flight.check.effects.empty());
  EXPECT_EQ(flight.check.effects.front().name, "lidar_angle_scale");
  for (const DiscrepancyCheck& discrepancy : flight.check.discrepancies) {
    EXPECT_GT(discrepancy.p_value, 0.01) << discrepancy.name;
  }
}

TEST(ModelCheck, NoiseOfThePairsIsNotADiscrepancy) {
  SimulatedFlight simulated = Fly(AircraftScenario(), 3);
  simulated.flight.config.lidar->sigma_p_m *= 0.5;
  const Checked flight(std::move(simulated));
  for (const DiscrepancyCheck& discrepancy : flight.check.discrepancies) {
    EXPECT_GT(discrepancy.p_value, 0.01) << discrepancy.name;
  }
}

TEST(ModelCheck, WithoutPairsTheTrajectoryIsChecked) {
  AdjustOptions options;
  options.with_pairs = false;
  for (const char* effects : {"", "effects: [{effect: gnss_time_offset, value: 0.03}]\n"}) {
    const SimulatedFlight simulated = Fly(DroneScenario(effects), 7);
    const Solution solution(simulated.flight, options);
    const ModelCheck& check = solution.model_check();
    EXPECT_FALSE(check.of_boresight);
    EXPECT_EQ(check.contradicted(), *effects != '\0');
    if (*effects == '\0') continue;
    ASSERT_FALSE(check.effects.empty());
    EXPECT_EQ(check.effects.front().name, "gnss_time_offset");
    EXPECT_NEAR(check.effects.front().estimate[0], 0.03, 0.003);
  }
}

}  // namespace dn::diagnosis_test
