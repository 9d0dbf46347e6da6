#include "noise_beyond_model.h"

#include <dn/adjustment/words.h>
#include <dn/diagnosis/solution.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "pair_clusters.h"
#include "share_pair_errors.h"
#include "testing/only_effect.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_test {

/// Rules out all unmodelled effects but one that moves nothing, so that only the noise counts.
void RuleOutEffects(SimulatedFlight* sim) {
  sim->flight.config.gnss->automatic_process = false;
  constexpr double kUsualPpm = 0.05;
  sim->flight.config.unmodelled = testing::OnlyEffect(EffectId::kGnssTimeDrift, kUsualPpm);
}

/// Returns a flight whose pairs share this part of their variance within tiles.
SimulatedFlight FlyShared(double share, double tile_m, unsigned seed) {
  const std::string scale = std::to_string(std::sqrt(1.0 - share));
  SimulatedFlight sim = testing::Fly(
      testing::AircraftScenario("effects: [{effect: p2p_noise_scale, value: " + scale + "}]\n"),
      seed);
  SharePairErrors(share, tile_m, seed, &sim);
  RuleOutEffects(&sim);
  return sim;
}

const EffectContribution* FindPart(const BoresightResult& boresight, const std::string& name) {
  const auto at = std::find_if(boresight.contributions.begin(), boresight.contributions.end(),
                               [&](const auto& part) { return part.effect == name; });
  return at == boresight.contributions.end() ? nullptr : &*at;
}

double Nees(const SimulatedFlight& sim, const Eigen::Vector3d& angles_rad,
            const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d error =
      Log(Eigen::Quaterniond(Exp(angles_rad) * Exp(sim.boresight_rad).conjugate()));
  return error.dot(covariance.llt().solve(error)) / 3.0;
}

TEST(NoiseBeyondModel, ClustersDivideAllRowsOfPairs) {
  const SimulatedFlight sim = testing::Fly(testing::AircraftScenario(), 3);
  const testing::Calibration calibration(sim.flight);
  const FlightNetwork& network = *calibration.adjustment.network;
  const std::vector<ResidualForm> forms =
      diagnosis_internal::PairClusters(network, calibration.marginals.linearized(), {15.0, 1e6});
  ASSERT_EQ(forms.size(), 6U);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const ResidualForm &small = forms[2 * axis], &large = forms[2 * axis + 1];
    EXPECT_EQ(small.channel, large.channel);
    EXPECT_EQ(std::count_if(small.label.begin(), small.label.end(), [](int k) { return k >= 0; }),
              static_cast<long>(network.pairs().edges().size()));
    // Four tiles of any size meet at the origin of the map, and each has up to three pairs of
    // strips.
    EXPECT_LE(large.labels, 4 * 3);
    EXPECT_GT(small.labels, large.labels);
  }
  EXPECT_EQ(forms[4].channel, "lidar p2p up");
}

TEST(NoiseBeyondModelManyRuns, SharedErrorsOfPairsAreInTheSigma) {
  double reported = 0.0, modelled = 0.0;
  constexpr int kFlights = 15;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedFlight sim = FlyShared(0.5, 60.0, seed);
    const BoresightResult boresight = Solution(sim.flight).CheckedBoresight();
    EXPECT_EQ(boresight.verdict, Verdict::kCalibrated) << Words(boresight.reasons.front());
    reported += Nees(sim, boresight.angles_rad, boresight.covariance_rad2) / kFlights;
    modelled +=
        Nees(sim, boresight.as_modelled->angles_rad, boresight.as_modelled->covariance_rad2) /
        kFlights;
    const EffectContribution* part = FindPart(boresight, "pair_shared_error");
    ASSERT_NE(part, nullptr);
    EXPECT_EQ(part->unit, "m");
    const double true_m = std::sqrt(0.5) * sim.flight.config.lidar->sigma_p_m;
    EXPECT_NEAR(part->estimate[0], true_m, 0.5 * true_m);
  }
  // Chi-square with 45 degrees of freedom: mean 1, 99.9 % below 1.78.
  EXPECT_LT(reported, 1.78);
  EXPECT_GT(modelled, 1.3 * reported);
}

// A trajectory follows errors that many pairs share. The inertial residuals are then large, and
// inertial effects seem to be there.
TEST(NoiseBeyondModelManyRuns, SharedErrorsOfPairsDoNotContradictTheInertialData) {
  int calibrated = 0;
  constexpr int kFlights = 6;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    Scenario scenario = testing::AircraftScenario();
    scenario.pairs.count = 3000;
    scenario.pairs.shared_fraction = 0.3;
    scenario.pairs.shared_length_m = 60.0;
    const SimulatedFlight sim = testing::Fly(scenario, seed);
    calibrated += Solution(sim.flight).CheckedBoresight().verdict == Verdict::kCalibrated ? 1 : 0;
  }
  EXPECT_GE(calibrated, kFlights - 1);
}

// Pairs that share no errors do not excuse too small a noise of the accelerometers.
TEST(NoiseBeyondModel, InertialNoiseThatNoOtherSensorExplainsIsReported) {
  const std::string effect = "effects: [{effect: accel_noise_scale, value: 20}]\n";
  const SimulatedFlight sim = testing::Fly(testing::AircraftScenario(effect), 3);
  const Solution solution(sim.flight);
  const std::vector<GroupCheck>& groups = solution.model_check().groups;
  const auto position = std::find_if(groups.begin(), groups.end(), [](const GroupCheck& group) {
    return group.name == "inertial position";
  });
  ASSERT_NE(position, groups.end());
  EXPECT_LT(position->p_value, 1e-3);
  EXPECT_FALSE(position->explained);
}

TEST(NoiseBeyondModel, NoiseOfAnotherSizeIsInTheSigma) {
  const std::string effect = "effects: [{effect: p2p_noise_scale, value: 1.38}]\n";
  SimulatedFlight sim = testing::Fly(testing::AircraftScenario(effect), 4);
  RuleOutEffects(&sim);
  const Solution solution(sim.flight);
  const BoresightResult boresight = solution.CheckedBoresight();
  EXPECT_EQ(boresight.verdict, Verdict::kCalibrated) << Words(boresight.reasons.front());
  const EffectContribution* part = FindPart(boresight, "lidar p2p noise");
  ASSERT_NE(part, nullptr);
  EXPECT_NEAR(part->estimate[0], 1.38, 0.1);
  // 400 residuals of an axis; the degrees of freedom have a margin for their own uncertainty.
  EXPECT_NEAR(part->sigma[0], 1.2 * 1.38 / std::sqrt(2.0 * 400.0), 0.01);
  const Eigen::Vector3d growth =
      boresight.sigma_rad().cwiseQuotient(boresight.as_modelled->sigma_rad());
  EXPECT_GT(growth.maxCoeff(), 1.1);
  EXPECT_LT(growth.maxCoeff(), 1.5);
}

// The largest tolerated variance is that of the noise: the ratio of a group or axis is often above.
TEST(NoiseBeyondModelManyRuns, ToleratedNoiseDoesNotContradictByChance) {
  const std::string effect = "effects: [{effect: p2p_noise_scale, value: 1.4}]\n";
  int above = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedFlight sim = testing::Fly(testing::AircraftScenario(effect), seed);
    const Solution solution(sim.flight);
    for (const GroupCheck& group : solution.model_check().groups) {
      if (group.name.rfind("lidar p2p", 0) == 0 && group.variance_ratio > 2.0) ++above;
    }
    EXPECT_NE(solution.CheckedBoresight().verdict, Verdict::kContradicted)
        << Words(solution.CheckedBoresight().reasons.front());
  }
  EXPECT_GT(above, 0);
}

TEST(NoiseBeyondModel, AFlightOfItsOwnModelHasNearlyTheSigmaOfTheModel) {
  double growth = 0.0;
  constexpr int kFlights = 6;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    SimulatedFlight sim = testing::Fly(testing::AircraftScenario(), seed);
    RuleOutEffects(&sim);
    const BoresightResult boresight = Solution(sim.flight).CheckedBoresight();
    growth += boresight.sigma_rad().cwiseQuotient(boresight.as_modelled->sigma_rad()).maxCoeff() /
              kFlights;
  }
  EXPECT_LT(growth, 1.08);
}

TEST(NoiseBeyondModel, ThePureModelHasNone) {
  SimulatedFlight sim = FlyShared(0.5, 60.0, 2);
  const BoresightResult with = Solution(sim.flight).CheckedBoresight();
  sim.flight.config.unmodelled.none = true;
  const Solution pure(sim.flight);
  EXPECT_EQ(pure.CheckedBoresight().covariance_rad2, pure.Boresight().covariance_rad2);
  EXPECT_EQ(pure.CheckedBoresight().angles_rad, with.as_modelled->angles_rad);
  for (const CommonErrorCheck& common : pure.model_check().common_errors) {
    EXPECT_FALSE(common.covered);
  }
}

}  // namespace dn::diagnosis_test
