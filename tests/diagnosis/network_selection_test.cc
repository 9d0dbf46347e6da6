#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "competing_hypotheses.h"
#include "forward_selection.h"
#include "network_fit.h"
#include "network_source.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using testing::AircraftScenario;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

constexpr double kNetworkThresholdNats = 6.0;

/// Result of a selection, and the evidence of the alternatives of each effect.
struct Selected {
  Selection model;
  std::vector<std::vector<HypothesisEvidence>> alternatives;
};

Selected Select(const Flight& flight) {
  const GapOptions options;
  NetworkSource source(flight, options);
  SelectionPolicy policy;
  policy.threshold_nats = kNetworkThresholdNats;
  policy.resizes_noise = true;
  policy.next = BestPhysical;
  policy.refine = [&](const ExtendedFit& fit, const HypothesisEvidence& effect) {
    return source.Refine(fit, effect);
  };
  ForwardSelection selection(
      policy, [&](const auto& chosen) { return source.Fit(chosen); }, source.Fit({}));
  selection.Grow();
  selection.Revise();
  std::vector<std::vector<HypothesisEvidence>> alternatives = selection.Alternatives();
  return {selection.Take(), std::move(alternatives)};
}

std::vector<std::string> Names(const Selected& selected) {
  std::vector<std::string> names;
  for (const HypothesisEvidence& effect : selected.model.chosen) names.push_back(effect.name);
  return names;
}

TEST(NetworkSelection, FindsBothOfTwoEffects) {
  const Flight flight =
      Simulate(AircraftScenario("effects: [{effect: lidar_range_offset, value: 0.15}, "
                                "{effect: gnss_lever_arm, value: [0.15, 0.1, 0]}]"),
               {})
          .flight;
  const Selected selected = Select(flight);
  EXPECT_THAT(Names(selected), UnorderedElementsAre("lidar_range_offset", "gnss_lever_arm"));
  ASSERT_NE(selected.model.final, nullptr);
  EXPECT_EQ(selected.alternatives.size(), 2u);
  for (const HypothesisEvidence& effect : selected.model.final->chosen) {
    if (effect.name != "lidar_range_offset") continue;
    EXPECT_NEAR(effect.estimate[0], 0.15, 4.0 * effect.sigma[0]);
  }
  EXPECT_LT(selected.model.final->effects.front().log_evidence, kNetworkThresholdNats);
}

// Both effects enlarge the misclosures of the pairs. Once the scale is known, the noise (of either
// kind, as they look alike) takes its true size. No third effect has to compensate for it.
TEST(NetworkSelection, ANoiseHasTheSizeThatItHasBesideWhatIsFoundAfterIt) {
  const Flight flight =
      Simulate(AircraftScenario("effects: [{effect: p2p_noise_scale, value: 1.6}, "
                                "{effect: lidar_angle_scale, value: 800}]"),
               {})
          .flight;
  const Selected selected = Select(flight);
  EXPECT_THAT(Names(selected), UnorderedElementsAre(AnyOf("p2p_noise_scale", "p2p_range_noise"),
                                                    "lidar_angle_scale"));
  ASSERT_NE(selected.model.final, nullptr);
  EXPECT_LT(selected.model.final->effects.front().log_evidence, kNetworkThresholdNats);
}

/// Returns the results for flights with the same effect and different seeds.
std::vector<Selected> SelectForSeeds(const std::string& effect) {
  std::vector<Selected> all;
  for (const std::uint64_t seed : {1, 2, 3}) {
    SimulateOptions options;
    options.seed = seed;
    all.push_back(Select(Simulate(AircraftScenario("effects: [" + effect + "]"), options).flight));
  }
  return all;
}

// Outliers must not count as scaled noise, even if they are too small to be rejected or occur at
// consecutive epochs.
TEST(NetworkSelection, GrossErrorsAreNotALargerNoiseAsWell) {
  for (const char* effect : {"{effect: gnss_outliers, value: [0.08, 0.2]}",
                             "{effect: p2p_outliers, value: [0.08, 1.0]}"}) {
    for (const Selected& selected : SelectForSeeds(effect)) {
      ASSERT_EQ(selected.model.chosen.size(), 1u) << effect;
      const GapCause cause = ToCause(selected.model.chosen[0]);
      EXPECT_THAT(effect, HasSubstr(cause.effect));
      EXPECT_NEAR(cause.estimate[0], 0.08, 3.0 * cause.sigma[0]) << effect;
    }
  }
}

// The error of the trajectory has several explanations, but the raw data show the noise itself.
TEST(NetworkSelection, RawNoiseIsNoProcess) {
  for (const Selected& selected : SelectForSeeds("{effect: gyro_noise_scale, value: 2.4}")) {
    EXPECT_THAT(Names(selected), ElementsAre("gyro_noise_scale"));
  }
}

/// Returns the strongest oscillation of the GNSS positions that remains with the causes in the
/// model.
const HypothesisEvidence& OscillationLeft(const Selected& selected) {
  const ExtendedFit& last = selected.model.last();
  const auto found = std::find_if(
      last.effects.begin(), last.effects.end(),
      [](const HypothesisEvidence& effect) { return effect.name == "GNSS oscillation"; });
  return found == last.effects.end() ? throw std::runtime_error("none screened") : *found;
}

// Correlated noise absorbs oscillations in size and time, but not the concentration of their power.
TEST(NetworkSelection, WavesAreNotAllOfACorrelatedNoise) {
  constexpr double kPeriodS = 40.0;
  SimulateOptions options;
  options.own.antenna_enu_m = [](double t_s) {
    const double phase = 2.0 * std::numbers::pi * t_s / kPeriodS;
    return Eigen::Vector3d(0.06 * std::sin(phase), 0.05 * std::cos(phase), 0.08 * std::sin(phase));
  };
  const Flight flight = Simulate(AircraftScenario(), options).flight;
  const HypothesisEvidence left = OscillationLeft(Select(flight));
  EXPECT_GT(left.log_evidence, kNetworkThresholdNats);
  ASSERT_TRUE(left.period_s.has_value());
  EXPECT_NEAR(*left.period_s, kPeriodS, 0.15 * kPeriodS);
}

TEST(NetworkSelection, ACorrelatedNoiseLeavesNoOscillation) {
  for (const Selected& selected :
       SelectForSeeds("{effect: gnss_correlated_noise, value: [0.06, 0.06, 0.1, 20]}")) {
    EXPECT_THAT(Names(selected), ElementsAre("gnss_correlated_noise"));
    EXPECT_LT(OscillationLeft(selected).log_evidence, kNetworkThresholdNats);
  }
}

// The two differ in level flight, where the first one has no error.
TEST(NetworkSelection, MultipathInTurnsIsNoCorrelatedNoise) {
  for (const Selected& selected :
       SelectForSeeds("{effect: gnss_multipath, value: [0.08, 0.08, 0.14, 20]}")) {
    EXPECT_THAT(Names(selected), ElementsAre("gnss_multipath"));
    const HypothesisEvidence& found = selected.model.chosen.front();
    EXPECT_NEAR(std::log(found.estimate[0] / 0.08), 0.0, 1.0);
  }
}

/// Returns a scenario of three strips, with the last one flown in both directions.
Scenario FourStrips(const std::string& extra = "") {
  Scenario scenario = AircraftScenario(extra);
  PlannedLine back = scenario.plan.lines.back();
  std::swap(back.start_en_m, back.end_en_m);
  back.start_en_m.x() += 100.0;
  back.end_en_m.x() += 100.0;
  scenario.plan.lines.push_back(back);
  return scenario;
}

/// Returns the screen of a flight whose boresight moves.
std::vector<HypothesisEvidence> Moving(const std::function<Eigen::Vector3d(const MapPose&)>& move) {
  SimulateOptions options;
  options.own.boresight_rad = move;
  const Flight flight = Simulate(FourStrips(), options).flight;
  const GapOptions gap;
  return NetworkFitter(flight, gap).Fit({}).effects;
}

const Eigen::Vector3d kMove_rad(6e-4, -5e-4, 6e-4);

TEST(NetworkFitter, ABoresightThatSettlesIsNoStepAndNoDrift) {
  constexpr double kTauS = 25.0;
  std::optional<double> first_s;
  const auto effects = Moving([&](const MapPose& pose) {
    if (!first_s) first_s = pose.t_s;
    return Eigen::Vector3d(std::exp(-(pose.t_s - *first_s) / kTauS) * kMove_rad);
  });
  const double settling = FindEvidence(effects, "boresight that settles");
  EXPECT_GT(settling, kNetworkThresholdNats);
  EXPECT_GT(settling, FindEvidence(effects, "boresight_step") + 3.0);
  EXPECT_GT(settling, FindEvidence(effects, "boresight_drift") + 3.0);
  const auto found = std::find_if(
      effects.begin(), effects.end(),
      [](const HypothesisEvidence& effect) { return effect.name == "boresight that settles"; });
  ASSERT_TRUE(found->decay_s.has_value());
  EXPECT_GT(*found->decay_s, 0.5 * kTauS);
  EXPECT_LT(*found->decay_s, 2.0 * kTauS);
}

TEST(NetworkFitter, ABoresightThatFollowsTheHeadingIsNoStep) {
  const auto effects = Moving([](const MapPose& pose) {
    return Eigen::Vector3d((pose.q_mb * Eigen::Vector3d::UnitX()).x() * kMove_rad);
  });
  const double heading = FindEvidence(effects, "boresight by heading");
  EXPECT_GT(heading, kNetworkThresholdNats);
  EXPECT_GT(heading, FindEvidence(effects, "boresight_step") + 3.0);
  EXPECT_GT(heading, FindEvidence(effects, "boresight_drift") + 3.0);
}

// Discrepancies that partly resemble a step or a drift must not replace its name.
TEST(NetworkFitter, StepsAndDriftsKeepTheirNames) {
  for (const char* effect : {"{effect: boresight_step, value: [0.02, -0.02, 0.03], t0_s: 381190}",
                             "{effect: boresight_drift, value: [0.15, -0.12, 0.15]}"}) {
    const Flight flight = Simulate(FourStrips("effects: [" + std::string(effect) + "]"), {}).flight;
    const GapOptions gap;
    const auto effects = NetworkFitter(flight, gap).Fit({}).effects;
    const HypothesisEvidence* best = BestPhysical(effects);
    ASSERT_NE(best, nullptr);
    EXPECT_THAT(effect, HasSubstr(best->name));
    EXPECT_GT(best->log_evidence, FindEvidence(effects, "boresight that settles")) << effect;
    EXPECT_GT(best->log_evidence, FindEvidence(effects, "boresight by heading")) << effect;
  }
}

TEST(NetworkSelection, FindsNothingInNoise) {
  const Flight flight = Simulate(AircraftScenario(), {}).flight;
  const Selected selected = Select(flight);
  EXPECT_TRUE(selected.model.chosen.empty());
  EXPECT_EQ(selected.model.final, nullptr);
  EXPECT_TRUE(selected.alternatives.empty());
}

}  // namespace dn::diagnosis_internal
