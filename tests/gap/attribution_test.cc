#include "attribution.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "testing/short_flights.h"

namespace dn::internal {
namespace {

using testing::AircraftScenario;
using ::testing::UnorderedElementsAre;

constexpr double kThresholdNats = 6.0;

Attribution Attributed(const Flight& flight) {
  const GapOptions options;
  const Explainer explainer(flight, options);
  return Attribute(explainer, std::make_unique<ExplainedFlight>(explainer.Explain({})),
                   kThresholdNats);
}

std::vector<std::string> Names(const Attribution& attribution) {
  std::vector<std::string> names;
  for (const GapCause& cause : attribution.causes) names.push_back(cause.effect);
  return names;
}

TEST(Attribute, FindsBothOfTwoEffects) {
  const Flight flight =
      Simulate(AircraftScenario("effects: [{effect: lidar_range_offset, value: 0.15}, "
                                "{effect: gnss_lever_arm, value: [0.15, 0.1, 0]}]"),
               {})
          .flight;
  const Attribution attribution = Attributed(flight);
  EXPECT_THAT(Names(attribution), UnorderedElementsAre("lidar_range_offset", "gnss_lever_arm"));
  ASSERT_NE(attribution.final, nullptr);
  EXPECT_EQ(attribution.slots.size(), 2u);
  for (const UnknownEstimate& unknown : attribution.final->solution->Unknowns()) {
    if (unknown.name != "lidar_range_offset") continue;
    EXPECT_NEAR(unknown.value[0], 0.15, 4.0 * unknown.sigma[0]);
  }
  EXPECT_LT(attribution.final->effects.front().log_evidence, kThresholdNats);
}

TEST(Attribute, FindsNothingInNoise) {
  const Flight flight = Simulate(AircraftScenario(), {}).flight;
  const Attribution attribution = Attributed(flight);
  EXPECT_TRUE(attribution.causes.empty());
  EXPECT_EQ(attribution.final, nullptr);
  ASSERT_EQ(attribution.slots.size(), 1u);
  EXPECT_EQ(attribution.slots[0].effect, "");
}

ScreenedEffect WithEvidence(const std::string& name, double nats, bool physical = true) {
  ScreenedEffect effect;
  effect.name = name;
  effect.physical = physical;
  effect.log_evidence = nats;
  return effect;
}

TEST(Posterior, IsBayes) {
  const std::vector<double> p = Posterior({WithEvidence("a", std::log(8.0)), WithEvidence("b", 0.0),
                                           WithEvidence("c", std::log(2.0), false)});
  // 0.5 nothing, 0.2 x 8 a, 0.2 b, 0.1 x 2 c.
  constexpr double kSum = 0.5 + 1.6 + 0.2 + 0.2;
  EXPECT_NEAR(p[0], 1.6 / kSum, 1e-12);
  EXPECT_NEAR(p[1], 0.2 / kSum, 1e-12);
  EXPECT_NEAR(p[2], 0.2 / kSum, 1e-12);
}

TEST(Posterior, OfHugeEvidenceIsOne) {
  const std::vector<double> p = Posterior({WithEvidence("a", 5000.0), WithEvidence("b", 4900.0)});
  EXPECT_NEAR(p[0], 1.0, 1e-12);
  EXPECT_LT(p[1], 1e-40);
}

}  // namespace
}  // namespace dn::internal
