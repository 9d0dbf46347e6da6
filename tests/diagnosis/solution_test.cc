#include <dn/adjustment/words.h>
#include <dn/diagnosis/solution.h>
#include <gtest/gtest.h>

#include <type_traits>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {

// A temporary flight would be destroyed before its solution.
static_assert(!std::is_constructible_v<Solution, Flight&&>);

SimulatedFlight FlyWithEffects(const std::string& effects = "") {
  SimulateOptions options;
  options.seed = 5;
  return Simulate(testing::DroneScenario(effects), options);
}

TEST(SolutionManyRuns, EqualsItsPartsOneByOne) {
  const SimulatedFlight sim = FlyWithEffects();
  const Solution solution(sim.flight);
  const Adjustment& adjustment = solution.adjustment();
  const Marginals& marginals = solution.marginals();
  const TrajectoryResult trajectory = ExtractTrajectory(adjustment, marginals);
  EXPECT_EQ(solution.trajectory().figures.chi2, trajectory.figures.chi2);
  EXPECT_EQ(solution.trajectory().sigma.back().rph_rad, trajectory.sigma.back().rph_rad);
  EXPECT_EQ(solution.model_check().p_value, CheckModel(adjustment, marginals, trajectory).p_value);
  EXPECT_EQ(solution.Boresight().covariance_rad2,
            ExtractBoresight(adjustment, marginals).covariance_rad2);
  EXPECT_NEAR(solution.linearized().residual().squaredNorm(), trajectory.figures.chi2,
              1e-9 * trajectory.figures.chi2);
  EXPECT_EQ(&solution.network(), adjustment.network.get());
}

TEST(Solution, ExpensiveResultsAreComputedOnce) {
  const SimulatedFlight sim = FlyWithEffects();
  const Solution solution(sim.flight);
  EXPECT_EQ(&solution.trajectory(), &solution.trajectory());
  EXPECT_EQ(&solution.model_check(), &solution.model_check());
}

TEST(Solution, TheModelCheckOverridesTheVerdict) {
  const SimulatedFlight sim =
      FlyWithEffects("effects: [{effect: gnss_time_offset, value: 0.05}]\n");
  const Solution solution(sim.flight);
  EXPECT_NE(solution.Boresight().verdict, Verdict::kContradicted);
  EXPECT_EQ(solution.CheckedBoresight().verdict, Verdict::kContradicted);
}

}  // namespace dn::diagnosis_test
