#include <dn/error.h>
#include <dn/fleet/fleet.h>
#include <dn/fleet/reduced_flight.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include "fleet/toy_fleet.h"
#include "testing/short_flights.h"

namespace dn::fleet_test {

/// A solved flight of a drone that estimates the offset of the ranges, with and without the effects
/// that the model leaves out.
struct Solved {
  SimulatedFlight sim;
  Solution solution;

  Solved(std::uint64_t seed, const std::string& unmodelled)
      : sim(Simulated(seed, unmodelled)), solution(sim.flight) {}

  static SimulatedFlight Simulated(std::uint64_t seed, const std::string& unmodelled) {
    SimulatedFlight sim = testing::Fly(testing::DroneScenario(), seed);
    sim.flight.config.estimate = {{.unknown = "boresight"},
                                  {.unknown = "lidar_range_offset", .sigma = {0.02}}};
    sim.flight.config.unmodelled.none = unmodelled == "none";
    // Networks that are appended to each other have each prior twice.
    if (unmodelled == "none") sim.flight.config.estimate.back().sigma.clear();
    return sim;
  }

  ReducedFlight Reduced() const { return ReduceFlight(solution, solution.CheckedBoresight()); }
};

TEST(ReducedFlight, HasTheReportedCovariances) {
  const Solved solved(3, "");
  const BoresightResult boresight = solved.solution.CheckedBoresight();
  const ReducedFlight flight = ReduceFlight(solved.solution, boresight);
  const Matrix3d C = flight.covariance.topLeftCorner<3, 3>();
  EXPECT_LT((C - boresight.covariance_rad2).norm(), 1e-9 * C.norm());
  const UnknownEstimate offset = solved.solution.CheckedUnknowns().front();
  EXPECT_NEAR(flight.mean[3], offset.value[0], 1e-12);
  EXPECT_NEAR(std::sqrt(flight.covariance(3, 3)), offset.sigma[0], 1e-9 * offset.sigma[0]);
  for (const EffectContribution& part : boresight.contributions) {
    Index row = 3;
    for (const ReducedEffect& effect : flight.effects) {
      if (!effect.estimated && EffectName(effect.effect) == part.effect) {
        const double to_si = EffectRow(effect.effect).components.front().to_si;
        EXPECT_NEAR(flight.mean[row], to_si * part.estimate[0], 1e-9 * to_si * part.sigma[0]);
        EXPECT_EQ(effect.remedy, part.remedy);
      }
      row += effect.prior_sigma.size();
    }
  }
}

TEST(ReducedFlightManyRuns, TwoOfThePureModelEqualOneNetwork) {
  const Solved monday(3, "none"), tuesday(4, "none");
  Network both;
  const std::vector<std::string> shared{"boresight", "lidar_range_offset"};
  both.Append(monday.solution.network().net(), "monday/", shared);
  both.Append(tuesday.solution.network().net(), "tuesday/", shared);
  ASSERT_TRUE(Solve(both, {.initial_trust_region_radius = 1e13}).converged);
  const auto boresight = both.Find<LeftRotation>("boresight");
  const Matrix3d C = MarginalCovariance(both, boresight);
  const AcrossConfig across{.unknowns = {"lidar_range_offset"}};
  const FleetResult fleet = AdjustFleet({monday.Reduced(), tuesday.Reduced()}, across);
  const Vector3d difference =
      Log(Eigen::Quaterniond(Exp(fleet.boresight.angles_rad) * both.Value(boresight).conjugate()));
  const Vector3d sigma = C.diagonal().cwiseSqrt();
  // To second order: the flights are linearised at their own solutions.
  EXPECT_LT(difference.cwiseQuotient(sigma).norm(), 0.02);
  EXPECT_LT((fleet.boresight.covariance_rad2 - C).norm(), 0.01 * C.norm());
  ASSERT_EQ(fleet.unknowns.size(), 1u);
  const double offset_sigma =
      std::sqrt(Marginals(both).Covariance(both.Find("lidar_range_offset"))(0, 0));
  EXPECT_NEAR(fleet.unknowns.front().sigma[0], offset_sigma, 0.01 * offset_sigma);
}

TEST(ReducedFlight, ReadsBack) {
  ReducedFlight flight = MakeAlike(1, 5).flights.front();
  flight.reasons = {"a reason"};
  flight.prior_angles_rad = flight.prior_sigma_rad = Vector3d(0.1, 0.2, 0.3);
  flight.effects.front().prior_sigma[0] = std::numeric_limits<double>::infinity();
  const Json json = ReducedFlightJson(flight);
  const Json read = ParseJson(FormatJson(json), "reduced.json");
  EXPECT_EQ(ReducedFlightJson(ReadReducedFlight(read)), json);
}

TEST(ReducedFlight, RefusesWhatIsNotOne) {
  const Json json = ReducedFlightJson(MakeAlike(1, 5).flights.front());
  for (const auto& [key, value] : {std::pair<std::string, Json>("schema", "dn.result/1"),
                                   {"covariance", Json::array({1.0})},
                                   {"mean", {1.0}},
                                   {"verdict", "good"}}) {
    Json changed = json;
    changed[key] = value;
    EXPECT_THROW(ReadReducedFlight(changed), InvalidInput) << key;
  }
  Json indefinite = json;
  indefinite["covariance"][0][0] = -1.0;
  EXPECT_THROW(ReadReducedFlight(indefinite), InvalidInput);
}

}  // namespace dn::fleet_test
