#include "unmodelled.h"

#include <dn/diagnosis/solution.h>
#include <dn/files/unmodelled.h>
#include <dn/sim/draw_effects.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <string>
#include <vector>

#include "testing/only_effect.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using diagnosis_internal::CellRange;
using diagnosis_internal::Hypothesis;
using diagnosis_internal::Library;
using diagnosis_internal::MakeHypothesis;
using diagnosis_internal::UnmodelledUnknowns;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Effects with one column block each, and their joint score for random data. The residuals are r =
/// J x + L e with three unknowns x.
struct Toy {
  static constexpr Index kRows = 60;
  Library library;
  JointScore score;
  MatrixXd J = MatrixXd::Random(kRows, 3), L;
  VectorXd r = VectorXd::Random(kRows);
  VectorXd sigma;

  explicit Toy(const UnmodelledPrior& prior) {
    for (const EffectId id :
         {EffectId::kLidarLeverArm, EffectId::kLidarScanCone, EffectId::kLidarRangeScale}) {
      score.first.push_back(L.cols());
      library.hypotheses.push_back(MakeHypothesis(id, library.blocks.size()));
      library.blocks.emplace_back();
      const VectorXd one = prior.Sigma(id);
      L.conservativeResize(kRows, L.cols() + one.size());
      // One prior sigma changes a residual by about one: the data show a part of each effect.
      L.rightCols(one.size()) =
          MatrixXd::Random(kRows, one.size()) *
          one.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 1.0; }).asDiagonal();
      sigma.conservativeResize(L.cols());
      sigma.tail(one.size()) = one;
    }
    score.first.push_back(L.cols());
    const MatrixXd N_inverse = (J.transpose() * J).inverse();
    r -= J * (N_inverse * (J.transpose() * r));  // residuals at the minimum
    score.s = L.transpose() * r;
    score.A = L.transpose() * L - (L.transpose() * J) * N_inverse * (J.transpose() * L);
    score.signature2 = (L.transpose() * L).diagonal();
    score.shift = N_inverse * J.transpose() * L;
  }

  /// Returns normal matrix and estimate of x and all effects, each effect with its prior.
  MatrixXd Normal() const {
    MatrixXd all(kRows, 3 + L.cols());
    all << J, L;
    MatrixXd N = all.transpose() * all;
    for (Index k = 0; k < sigma.size(); ++k) N(3 + k, 3 + k) += 1.0 / (sigma[k] * sigma[k]);
    return N;
  }
  VectorXd Estimate() const {
    MatrixXd all(kRows, 3 + L.cols());
    all << J, L;
    return -Normal().llt().solve(all.transpose() * r);
  }
};

TEST(UnmodelledUnknowns, EqualUnknownsWithPriorsInTheAdjustment) {
  const UnmodelledPrior prior(SensorClass::kTactical);
  const Toy toy(prior);
  const UnmodelledUnknowns unknowns(toy.library, prior, toy.score);
  const VectorXd expected = toy.Estimate();
  EXPECT_LT((unknowns.Correction() - expected.head<3>()).norm(), 1e-9 * expected.head<3>().norm());
  const VectorXd e = expected.tail(toy.sigma.size()).cwiseQuotient(toy.sigma);
  EXPECT_LT((unknowns.estimate().cwiseQuotient(toy.sigma) - e).norm(), 1e-9 * e.norm());
  const MatrixXd C = toy.Normal().inverse().topLeftCorner<3, 3>();
  const MatrixXd pure = (toy.J.transpose() * toy.J).inverse();
  EXPECT_LT((pure + unknowns.AddedCovariance() - C).norm(), 1e-9 * C.norm());
}

// The part of an effect beyond its prior is a second unknown with the same columns.
TEST(UnmodelledUnknowns, ConditionedScoresAreThoseOfASecondUnknownWithTheSameColumns) {
  const UnmodelledPrior prior(SensorClass::kTactical);
  const Toy toy(prior);
  const JointScore given = UnmodelledUnknowns(toy.library, prior, toy.score).Conditioned();
  MatrixXd all(Toy::kRows, 3 + toy.L.cols());
  all << toy.J, toy.L;
  const MatrixXd N_inverse = toy.Normal().inverse();
  const VectorXd s =
      toy.L.transpose() * toy.r - toy.L.transpose() * all * (N_inverse * (all.transpose() * toy.r));
  const MatrixXd A =
      toy.L.transpose() * toy.L - toy.L.transpose() * all * N_inverse * all.transpose() * toy.L;
  const MatrixXd shift = (N_inverse * all.transpose() * toy.L).topRows<3>();
  const auto by_size = [&](const MatrixXd& X) { return X * toy.sigma.asDiagonal(); };
  EXPECT_LT((given.s - s).cwiseProduct(toy.sigma).norm(), 1e-8);
  EXPECT_LT((toy.sigma.asDiagonal() * by_size(given.A - A)).norm(), 1e-8);
  EXPECT_LT(by_size(given.shift - shift).norm(), 1e-8 * by_size(shift).norm());
}

TEST(UnmodelledUnknowns, AComponentThatIsRuledOutChangesNothing) {
  UnmodelledPrior prior(SensorClass::kTactical);
  prior.Set(EffectId::kLidarLeverArm, Eigen::Vector3d(0.01, 0.0, 0.01));
  prior.Set(EffectId::kLidarScanCone, VectorXd::Zero(1));
  const Toy toy(prior);
  const UnmodelledUnknowns unknowns(toy.library, prior, toy.score);
  EXPECT_EQ(unknowns.components().size(), 3U);
  EXPECT_EQ(unknowns.estimate()[1], 0.0);
  EXPECT_EQ(unknowns.estimate()[3], 0.0);
  const UnmodelledUnknowns none(toy.library, UnmodelledPrior(), toy.score);
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.Conditioned().A, toy.score.A);
}

TEST(UnmodelledUnknowns, HaveNoStartsOfAStep) {
  UnmodelledPrior prior;
  prior.Set(EffectId::kLidarLeverArm, Eigen::Vector3d::Constant(0.01));
  Toy toy(prior);
  Hypothesis step = MakeHypothesis(EffectId::kBoresightStep, 0);
  step.cells = CellRange{0, 1};
  toy.library.hypotheses.push_back(step);
  prior.Set(EffectId::kBoresightStep, Eigen::Vector3d::Constant(1e-5));
  EXPECT_EQ(UnmodelledUnknowns(toy.library, prior, toy.score).components(),
            (std::vector<Index>{0, 1, 2}));
}

TEST(UnmodelledUnknowns, ContributionsAreWhatKnowledgeOfAnEffectWouldSave) {
  const UnmodelledPrior prior(SensorClass::kTactical);
  const Toy toy(prior);
  const UnmodelledUnknowns unknowns(toy.library, prior, toy.score);
  UnmodelledPrior without_cone = prior;
  without_cone.Set(EffectId::kLidarScanCone, VectorXd::Zero(1));
  const VectorXd saved =
      (unknowns.AddedCovariance() -
       UnmodelledUnknowns(toy.library, without_cone, toy.score).AddedCovariance())
          .diagonal();
  for (const EffectContribution& part : unknowns.Contributions({0})) {
    if (part.effect != EffectName(EffectId::kLidarScanCone)) continue;
    EXPECT_LT((part.angle_sigma_rad.cwiseAbs2() - saved).norm(), 1e-9 * saved.norm());
  }
}

/// Returns `estimate:` with every effect of a prior and its sigma.
std::vector<EstimateEntry> EstimateAll(const UnmodelledPrior& prior) {
  std::vector<EstimateEntry> entries{{.unknown = "boresight"}};
  for (const EffectSpec& effect : EffectTable()) {
    if (!effect.fixed() || prior.Sigma(effect.id).isZero(0.0)) continue;
    EstimateEntry entry{.unknown = effect.name};
    for (std::size_t k = 0; k < effect.components.size(); ++k) {
      entry.sigma.push_back(prior.Sigma(effect.id)[static_cast<Index>(k)] /
                            effect.components[k].to_si);
    }
    entries.push_back(entry);
  }
  return entries;
}

TEST(UnmodelledManyRuns, OneInverseGivesWhatAnAdjustmentWithAllEffectsGives) {
  const UnmodelledPrior prior(SensorClass::kNavigation);
  Scenario scenario = testing::AircraftScenario();
  scenario.effects = DrawEffects(prior, 1.0, 3);
  SimulatedFlight sim = testing::Fly(scenario, 3);
  sim.flight.config.gnss->automatic_process = false;
  const Solution solution(sim.flight);
  const BoresightResult linear = solution.CheckedBoresight();
  const Eigen::Matrix3d effects =
      linear.covariance_rad2 - solution.model_check().unmodelled->noise_covariance_rad2;
  sim.flight.config.unmodelled.none = true;
  sim.flight.config.estimate = EstimateAll(prior);
  const BoresightResult refit = Solution(sim.flight).Boresight();
  const Eigen::Vector3d sigma = refit.sigma_rad();
  EXPECT_LT((linear.angles_rad - refit.angles_rad).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.1);
  const Eigen::Vector3d ratio = effects.diagonal().cwiseSqrt().cwiseQuotient(sigma);
  EXPECT_LT((ratio.array() - 1.0).abs().maxCoeff(), 0.01);
}

const std::string kWanderingGnss =
    "effects: [{effect: gnss_correlated_noise, value: [0.03, 0.03, 0.06, 60]}]\n";

/// Returns the contribution of the process of GNSS positions; null without it.
const EffectContribution* FindProcess(const BoresightResult& boresight) {
  for (const EffectContribution& part : boresight.contributions) {
    if (part.effect == "gnss_correlated_noise") return &part;
  }
  return nullptr;
}

// States of the network with the true size and time constant give nearly what the data give.
TEST(AutomaticGnssProcessManyRuns, EqualsAStatedProcessIfTheDataShowItsSize) {
  SimulatedFlight sim = testing::Fly(testing::AircraftScenario(kWanderingGnss), 3);
  const BoresightResult automatic = Solution(sim.flight).CheckedBoresight();
  ASSERT_NE(FindProcess(automatic), nullptr);
  EXPECT_NEAR(FindProcess(automatic)->estimate[0], 0.03, 0.012);
  sim.flight.config.gnss->processes = {{{0.03, 0.03, 0.06}, 60.0}};
  const BoresightResult stated = Solution(sim.flight).CheckedBoresight();
  EXPECT_EQ(FindProcess(stated), nullptr);
  const Eigen::Vector3d sigma = stated.sigma_rad();
  EXPECT_LT((automatic.angles_rad - stated.angles_rad).cwiseQuotient(sigma).cwiseAbs().maxCoeff(),
            0.4);
  EXPECT_LT((automatic.sigma_rad().cwiseQuotient(sigma).array() - 1.0).abs().maxCoeff(), 0.2);
}

TEST(AutomaticGnssProcess, IsInTheTrajectoryAndInThePlan) {
  SimulatedFlight sim = testing::Fly(testing::AircraftScenario(kWanderingGnss), 3);
  const Solution with(sim.flight);
  const std::vector<TrajectorySigma> sigma = with.CheckedSigmas();
  const BoresightResult planned = with.PredictedBoresight();
  ASSERT_NE(FindProcess(planned), nullptr);
  const double usual_m = FindProcess(planned)->prior[0];
  EXPECT_NEAR(FindProcess(planned)->estimate[0], usual_m, 0.01 * usual_m);
  sim.flight.config.gnss->automatic_process = false;
  const Solution without(sim.flight);
  EXPECT_EQ(FindProcess(without.PredictedBoresight()), nullptr);
  EXPECT_TRUE(
      (planned.sigma_rad().array() > without.PredictedBoresight().sigma_rad().array()).all());
  // The mean of an error of 3 cm over the flight cannot be known to less than 1 cm.
  const std::size_t middle = sigma.size() / 2;
  EXPECT_GT(sigma[middle].position_enu_m.x(), 0.01);
  EXPECT_LT(without.CheckedSigmas()[middle].position_enu_m.x(), 0.01);
}

TEST(AutomaticGnssProcess, ThePureModelIsWithoutIt) {
  SimulatedFlight sim = testing::Fly(testing::AircraftScenario(kWanderingGnss), 3);
  sim.flight.config.unmodelled.none = true;
  const BoresightResult automatic = Solution(sim.flight).CheckedBoresight();
  sim.flight.config.gnss->automatic_process = false;
  const BoresightResult none = Solution(sim.flight).CheckedBoresight();
  EXPECT_EQ(automatic.angles_rad, none.angles_rad);
  EXPECT_EQ(automatic.covariance_rad2, none.covariance_rad2);
}

TEST(Unmodelled, ThePureModelIsBeside) {
  SimulatedFlight sim = testing::Fly(testing::AircraftScenario(), 3);
  const BoresightResult with = Solution(sim.flight).CheckedBoresight();
  const BoresightResult pure = Solution(sim.flight).Boresight();
  ASSERT_TRUE(with.as_modelled);
  EXPECT_EQ(with.as_modelled->angles_rad, pure.angles_rad);
  EXPECT_EQ(with.as_modelled->covariance_rad2, pure.covariance_rad2);
  EXPECT_TRUE((with.sigma_rad().array() > pure.sigma_rad().array()).all());
  EXPECT_FALSE(with.contributions.empty());
  sim.flight.config.unmodelled.none = true;
  const BoresightResult none = Solution(sim.flight).CheckedBoresight();
  EXPECT_EQ(none.angles_rad, pure.angles_rad);
  EXPECT_FALSE(none.as_modelled);
}

// A tolerance is corrected as far as the data show it; an error of many prior sigmas is a fault.
TEST(Unmodelled, ATolerancePassesAndAFaultContradicts) {
  const auto verdict = [](const std::string& cone_deg) {
    const SimulatedFlight sim =
        testing::Fly(testing::AircraftScenario(
                         "effects: [{effect: lidar_scan_cone, value: " + cone_deg + "}]\n"),
                     3);
    return Solution(sim.flight).CheckedBoresight();
  };
  EXPECT_EQ(verdict("0.012").verdict, Verdict::kCalibrated);
  const BoresightResult fault = verdict("0.3");
  EXPECT_EQ(fault.verdict, Verdict::kContradicted);
  ASSERT_FALSE(fault.reasons.empty());
  const auto* present = fault.reasons.front().As<facts::EffectPresent>();
  ASSERT_NE(present, nullptr);
  EXPECT_EQ(present->effect.name, "lidar_scan_cone");
  EXPECT_GT(present->effect.prior_sigmas.value_or(0.0), 4.0);
}

TEST(Unmodelled, ADesignPredictsTheSigmaOfItsFlight) {
  SimulatedFlight sim = testing::Fly(testing::AircraftScenario(), 3);
  sim.flight.config.gnss->automatic_process = false;  // its size follows from the data
  const Solution solution(sim.flight);
  const Eigen::Matrix3d predicted = solution.PredictedBoresight().covariance_rad2;
  const Eigen::Matrix3d noise = solution.model_check().unmodelled->noise_covariance_rad2;
  const Eigen::Matrix3d adjusted = solution.CheckedBoresight().covariance_rad2 - noise;
  EXPECT_LT((predicted - adjusted).norm(), 1e-9 * adjusted.norm());
  EXPECT_LT(noise.diagonal().cwiseQuotient(adjusted.diagonal()).maxCoeff(), 0.1);
}

TEST(Unmodelled, SigmasOfTheTrajectoryContainThem) {
  const SimulatedFlight sim = testing::Fly(testing::AircraftScenario(), 3);
  const Solution solution(sim.flight);
  const std::vector<TrajectorySigma> sigma = solution.CheckedSigmas();
  const std::vector<TrajectorySigma>& pure = solution.trajectory().sigma;
  ASSERT_EQ(sigma.size(), pure.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < sigma.size(); ++k) {
    EXPECT_TRUE((sigma[k].rph_rad.array() >= pure[k].rph_rad.array()).all());
    largest = std::max(largest, sigma[k].rph_rad.cwiseQuotient(pure[k].rph_rad).maxCoeff());
  }
  EXPECT_GT(largest, 1.2);
}

// An effect that is left out with its prior is, to first order, an unknown of the adjustment with
// that prior. The biases and the poses at the nodes are the same.
TEST(UnmodelledManyRuns, BiasesAndPosesAreThoseOfAnAdjustmentWithTheEffectAsUnknown) {
  constexpr double kPriorPpm = 100.0;
  SimulatedFlight sim =
      testing::Fly(testing::AircraftScenario(
                       "effects: [{effect: accel_scale_factor, value: [100, 100, 100]}]\n"),
                   3);
  sim.flight.config.gnss->automatic_process = false;
  sim.flight.config.unmodelled = testing::OnlyEffect(EffectId::kAccelScaleFactor, kPriorPpm);
  const Solution left_out(sim.flight);
  const std::vector<BiasEstimate> biases = left_out.CheckedBiases();
  const std::vector<MapPose> poses = left_out.CheckedPoses();
  sim.flight.config.unmodelled.none = true;
  const std::vector<BiasEstimate> pure = Solution(sim.flight).trajectory().biases;
  sim.flight.config.estimate.push_back({"accel_scale_factor", {kPriorPpm}});
  const Solution estimated(sim.flight);
  double moved = 0.0;
  for (std::size_t k = 0; k < biases.size(); ++k) {
    const BiasEstimate& expected = estimated.trajectory().biases[k];
    const BiasEstimate& before = pure[k];
    const Eigen::Vector3d& sigma = expected.sigma_accel_mps2;
    EXPECT_LT((biases[k].sigma_accel_mps2 - sigma).norm(), 0.03 * sigma.norm());
    EXPECT_LT((biases[k].accel_mps2 - expected.accel_mps2).cwiseQuotient(sigma).norm(), 0.1);
    moved = std::max(moved, (before.accel_mps2 - expected.accel_mps2).cwiseQuotient(sigma).norm());
    const MapPose pose = estimated.network().trajectory().NodePose(k);
    EXPECT_LT((poses[k].p_mb - pose.p_mb).norm(), 1e-3);
  }
  EXPECT_GT(moved, 0.3);
}

}  // namespace dn::diagnosis_test
