#include <dn/adjustment/adjust.h>
#include <dn/error.h>
#include <dn/sim/random.h>
#include <dn/solvers/solve.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "testing/expect_invalid.h"
#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::adjustment_test {

using testing::AircraftScenario;
using testing::Calibration;
using testing::DroneScenario;
using testing::Fly;
using ::testing::HasSubstr;
using testing::kSigmas;

double Worst(const Calibration& c, const SimulatedFlight& sim) {
  return c.BoresightError(sim.boresight_rad)
      .cwiseQuotient(c.boresight.sigma_rad())
      .cwiseAbs()
      .maxCoeff();
}

TEST(Adjust, NoiseFreeFlightReturnsTheBoresight) {
  for (const Scenario& scenario : {DroneScenario(), AircraftScenario()}) {
    SCOPED_TRACE(scenario.name);
    const SimulatedFlight sim = Fly(scenario, 1, false);
    const Calibration c(sim.flight);
    EXPECT_LT(Worst(c, sim), 0.01);
    EXPECT_LT(c.BoresightError(sim.boresight_rad).norm() * kDegPerRad, 1e-5);
    EXPECT_EQ(c.adjustment.outliers, 0);
    EXPECT_LT(c.adjustment.residual_final_m, 1e-3);
    EXPECT_GT(c.adjustment.residual_initial_m, 0.1);
  }
}

TEST(AdjustManyRuns, NoisyFlightsStayWithinTheirSigmas) {
  double nees = 0.0, chi2 = 0.0, redundancy = 0.0;
  constexpr int kSeeds = 3;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const Scenario& scenario : {DroneScenario(), AircraftScenario()}) {
      SCOPED_TRACE(scenario.name);
      const SimulatedFlight sim = Fly(scenario, seed);
      const Calibration c(sim.flight);
      EXPECT_TRUE(c.adjustment.converged);
      EXPECT_LT(Worst(c, sim), kSigmas);
      const AdjustmentFigures figures = c.solution.trajectory().figures;
      const auto n = static_cast<double>(figures.redundancy);
      EXPECT_NEAR(figures.chi2 / n, 1.0, kSigmas * std::sqrt(2.0 / n));
      EXPECT_NEAR(figures.sigma0, std::sqrt(figures.chi2 / n), 1e-12);
      EXPECT_EQ(c.boresight.verdict, Verdict::kCalibrated);
      const Eigen::Vector3d e = c.BoresightError(sim.boresight_rad);
      nees += e.dot(c.boresight.covariance_rad2.ldlt().solve(e));
      chi2 += figures.chi2;
      redundancy += n;
    }
  }
  // The sum over the flights is a chi-square variable with three degrees of freedom per flight.
  const double n = 3.0 * 2.0 * kSeeds;
  EXPECT_NEAR(nees, n, kSigmas * std::sqrt(2.0 * n));
  EXPECT_NEAR(chi2 / redundancy, 1.0, kSigmas * std::sqrt(2.0 / redundancy));
}

TEST(Adjust, WrongPairsAreRejected) {
  SimulatedFlight sim = Fly(DroneScenario(), 5);
  constexpr double kShare = 0.2, kSmallestM = 0.5, kLargestM = 5.0;
  Random random(3, "wrong pairs");
  long wrong = 0;
  for (LidarPair& pair : sim.flight.pairs->pairs) {
    if (random.Uniform() > kShare) continue;
    pair.u_j_s += random.Uniform(kSmallestM, kLargestM) * random.Normal3().normalized();
    ++wrong;
  }
  const auto all = static_cast<double>(sim.flight.pairs->pairs.size());
  ASSERT_NEAR(static_cast<double>(wrong), kShare * all, 0.05 * all);
  const Calibration c(sim.flight);
  EXPECT_GE(c.adjustment.outliers, wrong) << "half a metre is more than ten sigmas";
  EXPECT_LE(c.adjustment.outliers, wrong + 3) << "6e-5 of the good ones are expected";
  EXPECT_LT(Worst(c, sim), kSigmas);
  const AdjustmentFigures figures = c.solution.trajectory().figures;
  EXPECT_EQ(figures.correspondences + figures.outliers, static_cast<long>(all));
  const auto n = static_cast<double>(figures.redundancy);
  EXPECT_NEAR(figures.chi2 / n, 1.0, kSigmas * std::sqrt(2.0 / n));
}

TEST(AdjustManyRuns, TwoRunsGiveIdenticalNumbers) {
  const SimulatedFlight sim = Fly(DroneScenario(), 6);
  const Calibration a(sim.flight), b(sim.flight);
  EXPECT_EQ(a.boresight.angles_rad, b.boresight.angles_rad);
  EXPECT_EQ(a.boresight.covariance_rad2, b.boresight.covariance_rad2);
  EXPECT_EQ(a.adjustment.cost, b.adjustment.cost);
  EXPECT_EQ(a.adjustment.iterations, b.adjustment.iterations);
  const std::size_t last = a.adjustment.network->nodes().size() - 1;
  EXPECT_EQ(a.adjustment.network->trajectory().NodePose(last).p_mb,
            b.adjustment.network->trajectory().NodePose(last).p_mb);
}

TEST(Adjust, WithoutPairsOnlyTheTrajectoryIsEstimated) {
  const SimulatedFlight sim = Fly(DroneScenario(), 2);
  AdjustOptions options;
  options.with_pairs = false;
  const Adjustment adjustment = Adjust(sim.flight, options);
  EXPECT_TRUE(adjustment.converged);
  EXPECT_TRUE(adjustment.network->pairs().edges().empty());
  EXPECT_EQ(adjustment.outliers, 0);
  const CostSummary summary = EvaluateCost(adjustment.network->net());
  const auto n = static_cast<double>(summary.residuals - summary.parameters);
  EXPECT_NEAR(2.0 * summary.cost / n, 1.0, kSigmas * std::sqrt(2.0 / n));
}

TEST(Adjust, StagesAreAnnouncedInOrder) {
  const SimulatedFlight sim = Fly(DroneScenario(), 2);
  std::vector<std::string> announced;
  AdjustOptions options;
  options.progress = [&](const std::string& stage, int iterations) {
    if (announced.empty() || announced.back() != stage) announced.push_back(stage);
    EXPECT_GE(iterations, 0);
  };
  const Adjustment adjustment = Adjust(sim.flight, options);
  ASSERT_GE(announced.size(), 4U);
  EXPECT_EQ(announced.front(), "alignment");
  EXPECT_EQ(announced.back(), "final least squares");
  int iterations = 0;
  for (const StageSummary& stage : adjustment.stages) {
    EXPECT_LE(stage.cost_after, stage.cost_before * (1.0 + 1e-12));
    iterations += stage.iterations;
  }
  EXPECT_EQ(adjustment.iterations, iterations);
}

TEST(Adjust, AnInterruptionEndsTheWork) {
  const SimulatedFlight sim = Fly(DroneScenario(), 2);
  int polls = 0;
  AdjustOptions options;
  options.interrupted = [&] { return ++polls > 5; };
  EXPECT_THROW(Adjust(sim.flight, options), Interrupted);
}

TEST(Adjust, TooFewIterationsAreNotPassedOffAsAResult) {
  const SimulatedFlight sim = Fly(DroneScenario(), 2);
  AdjustOptions options;
  options.max_iterations = 1;
  try {
    Adjust(sim.flight, options);
    FAIL() << "converged in one iteration";
  } catch (const NotConverged& e) {
    EXPECT_THAT(e.what(), HasSubstr("did not converge"));
  }
}

TEST(Adjust, MissingDataAndBadOptionsAreNamed) {
  const SimulatedFlight sim = Fly(DroneScenario(), 2);
  AdjustOptions threads, iterations;
  threads.threads = 0;
  iterations.max_iterations = 0;
  EXPECT_THROW(Adjust(sim.flight, threads), InvalidConfig);
  EXPECT_THROW(Adjust(sim.flight, iterations), InvalidConfig);
  Flight flight = sim.flight;
  flight.pairs.reset();
  testing::ExpectInvalid([&] { Adjust(flight); }, "no point-to-point pairs", 0);
  flight.gnss.reset();
  testing::ExpectInvalid([&] { Adjust(flight); }, "GNSS", 0);
}

TEST(Adjust, PairsThatConnectNoTwoNodesAreNamed) {
  SimulatedFlight sim = Fly(DroneScenario(), 2);
  for (LidarPair& pair : sim.flight.pairs->pairs) pair.t_j_s = pair.t_i_s;
  testing::ExpectInvalid([&] { Adjust(sim.flight); }, "same", 0);
}

TEST(Adjust, NoisierGyrosGetMoreNodes) {
  const SimulatedFlight drone = Fly(DroneScenario(), 2);
  Flight flight = drone.flight;
  const double mems_hz = AutoNodeRateHz(flight);
  flight.config.imu->model = ImuPreset("airins");
  EXPECT_LT(AutoNodeRateHz(flight), mems_hz);
}

TEST(Adjust, ADiagnosisHasFewerNodesAndNearlyTheSameSigmas) {
  const SimulatedFlight drone = Fly(DroneScenario(), 2);
  Flight flight = drone.flight;
  const double diagnosis_hz = AutoNodeRateHz(flight, NodeRateUse::kDiagnosis);
  EXPECT_LT(diagnosis_hz, AutoNodeRateHz(flight));
  const Calibration result(flight);
  flight.config.network.node_rate_hz = diagnosis_hz;
  const Calibration coarse(flight);
  for (int k = 0; k < 3; ++k) {
    const double sigma_rad = result.boresight.sigma_rad()[k];
    EXPECT_GT(coarse.boresight.sigma_rad()[k], 0.97 * sigma_rad);
    EXPECT_NEAR(coarse.boresight.angles_rad[k], result.boresight.angles_rad[k], 0.1 * sigma_rad);
  }
}

}  // namespace dn::adjustment_test
