#include <dn/diagnosis/solution.h>
#include <gtest/gtest.h>

#include <string>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {

// One wrong reading of a user's own sensor bends the trajectory, but the reading is named first.
TEST(IsolatedRows, AreTheFirstFinding) {
  const SimulatedFlight sim = testing::Fly(testing::DroneScenario(), 5);
  for (const bool with_others : {false, true}) {
    AdjustOptions options;
    options.customise = [&](FlightNetwork& network) {
      for (std::size_t k = with_others ? 60 : 100; k <= (with_others ? 140U : 100U); ++k) {
        const double wrong_m = k == 100 ? 30.0 : 0.0;
        const double reading_m = sim.truth->Pose(network.nodes()[k].t_s).p_mb.z() + wrong_m;
        const FactorId id =
            network.net().Add([=](const auto& p_mb) { return p_mb.z() - reading_m; },
                              Noise<1>::Sigma(0.05), network.nodes()[k].p_mb);
        network.net().Tag(id, {"altimeter", {{"up"}}}, network.nodes()[k].t_s);
      }
    };
    const Solution solution(sim.flight, options);
    ASSERT_FALSE(solution.model_check().findings.empty());
    const Finding& first = solution.model_check().findings.front();
    EXPECT_TRUE(first.contradicts);
    const auto* variance = first.As<facts::VarianceTooLarge>();
    ASSERT_NE(variance, nullptr);
    EXPECT_EQ(variance->group.name.rfind("altimeter", 0), 0U) << variance->group.name;
    EXPECT_NEAR(variance->group.worst_t_s, solution.network().nodes()[100].t_s, 1e-6);
  }
}

}  // namespace dn::diagnosis_test
