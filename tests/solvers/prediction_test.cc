#include <dn/error.h>
#include <dn/solvers/prediction.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"
#include "solvers/step_factor.h"

namespace dn::solvers_test {

using testing::MakePoseGraph;
using testing::MakeVectorPrior;
using testing::PoseGraph;
using testing::Step;

// The covariance is accurate to 1e-9 of its sigmas, and some hundred numbers are added.
constexpr double kSumTolerance = 1e-6;

TEST(Redundancy, NumbersSumToResidualsMinusParameters) {
  for (const bool held : {false, true}) {
    PoseGraph graph = MakePoseGraph(3, {.noise = 1.0});
    graph.network.Hold(graph.q_bs, held);
    graph.network.SetActive(graph.relative[5], false);
    Marginals marginals(graph.network);
    marginals.ComputeSelectedInverse();
    double sum = 0.0;
    for (FactorId id = 0; id < graph.network.num_factors(); ++id) {
      if (graph.network.factor(id).active) {
        sum += RedundancyNumbers(marginals, id).sum();
      }
    }
    const CostSummary summary = EvaluateCost(graph.network);
    EXPECT_NEAR(sum, static_cast<double>(summary.residuals - summary.parameters), kSumTolerance);
  }
}

// One unknown measured with sigma 1 and 3: the weights are 1 and 1/9, the shares of the fit 0.9 and
// 0.1.
TEST(Redundancy, OfTwoMeasurementsOfOneUnknown) {
  Network net;
  const auto x = net.AddVector<3>("x", Eigen::Vector3d::Zero());
  const FactorId fine = net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 1.0), x);
  const FactorId coarse = net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Ones(), 3.0), x);
  Marginals marginals(net);
  EXPECT_THROW(RedundancyNumbers(marginals, fine), InvalidInput) << "no selected inverse";
  marginals.ComputeSelectedInverse();
  EXPECT_NEAR(RedundancyNumbers(marginals, fine)[0], 0.1, 1e-12);
  EXPECT_NEAR(RedundancyNumbers(marginals, coarse)[2], 0.9, 1e-12);
  net.SetActive(coarse, false);
  EXPECT_NEAR(RedundancyNumbers(marginals, coarse)[2], 0.9, 1e-12)
      << "the snapshot must not change";
  Marginals without(net);
  without.ComputeSelectedInverse();
  EXPECT_THROW(RedundancyNumbers(without, coarse), InvalidInput);
}

// In a chain of noisy steps and noisy positions, residuals are divided by the square roots of their
// redundancy numbers. They then have variance one, separately for steps and positions.
TEST(Redundancy, StandardisesTheResiduals) {
  constexpr double kStepSigma = 0.2, kPositionSigma = 0.7;
  constexpr int kNodes = 300;
  std::mt19937 rng(4);
  const auto noise = [&rng](double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    return Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
  };
  Network net;
  std::vector<Block<Vec<3>>> x;
  std::vector<FactorId> steps, positions;
  for (int k = 0; k < kNodes; ++k) {
    x.push_back(net.AddVector<3>("x/" + std::to_string(k), Eigen::Vector3d::Zero()));
    positions.push_back(
        net.Add(MakeVectorPrior<3>(noise(kPositionSigma), kPositionSigma), x.back()));
    if (k == 0) continue;
    Step step;
    step.z = noise(kStepSigma);
    step.sigma = kStepSigma;
    steps.push_back(net.Add(step, x[x.size() - 2], x.back()));
  }
  ASSERT_TRUE(Solve(net).converged);
  Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  for (const auto& ids : {steps, positions}) {
    double sum2 = 0.0, n = 0.0;
    for (const FactorId id : ids) {
      Eigen::VectorXd r;
      ASSERT_TRUE(net.EvaluateFactor(id, &r));
      sum2 += r.squaredNorm();
      n += RedundancyNumbers(marginals, id).sum();
    }
    EXPECT_NEAR(sum2 / n, 1.0, 4.0 * std::sqrt(2.0 / n));
  }
}

/// A chain of noisy steps with noisy positions at every node.
struct PredictedChain {
  Network net;
  std::vector<Block<Vec<3>>> x;
  std::vector<FactorId> positions;

  explicit PredictedChain(int nodes) {
    std::mt19937 rng(8);
    std::normal_distribution<double> normal;
    const auto noise = [&] { return Eigen::Vector3d(normal(rng), normal(rng), normal(rng)); };
    for (int k = 0; k < nodes; ++k) {
      x.push_back(net.AddVector<3>("x/" + std::to_string(k), Eigen::Vector3d::Zero()));
      positions.push_back(net.Add(MakeVectorPrior<3>(noise(), 1.0), x.back()));
      Step step;
      step.z = 0.3 * noise();
      step.sigma = 0.3;
      if (k > 0) net.Add(step, x[x.size() - 2], x.back());
    }
  }

  Prediction Predict(FactorId id) {
    SolveOptions options;
    options.function_tolerance = 1e-16;
    EXPECT_TRUE(Solve(net, options).converged);
    Marginals marginals(net);
    marginals.ComputeSelectedInverse();
    return PredictFactor(marginals, id);
  }
};

// The prediction from the adjustment with the factor must equal that from the adjustment without
// it.
TEST(Prediction, EqualsTheAdjustmentWithoutTheFactor) {
  for (const bool robust : {false, true}) {
    PredictedChain chain(20);
    const FactorId id = chain.positions[7];
    if (robust) chain.net.SetLoss(id, {Loss::Type::kHuber, 0.2});
    const Prediction with = chain.Predict(id);
    chain.net.SetActive(id, false);
    const Prediction without = chain.Predict(id);
    EXPECT_LT((with.residual - without.residual).norm(), 1e-6);
    EXPECT_LT((with.covariance - without.covariance).norm(), 1e-6);
    EXPECT_NEAR(with.statistic, without.statistic, 1e-5);
    EXPECT_GT(with.covariance(0, 0), 1.0);
  }
}

TEST(Prediction, SaysWhenTheOthersLeaveTheUnknownsFree) {
  PredictedChain chain(5);
  for (std::size_t k = 1; k < chain.positions.size(); ++k) {
    chain.net.SetActive(chain.positions[k], false);
  }
  EXPECT_FALSE(chain.Predict(chain.positions[0]).determined);
  chain.net.SetActive(chain.positions[4], true);
  EXPECT_TRUE(chain.Predict(chain.positions[0]).determined);
}

// An inactive factor may depend on an unknown that no other factor determines.
TEST(Prediction, SaysSoOfAnUnknownThatOnlyTheFactorSees) {
  Network net;
  const auto x = net.AddVector<3>("x", Eigen::Vector3d::Zero());
  const auto y = net.AddVector<3>("y", Eigen::Vector3d::Zero());
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 1.0), x);
  const FactorId step = net.Add(Step{}, x, y);
  net.SetActive(step, false);
  Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  EXPECT_FALSE(PredictFactor(marginals, step).determined);
}

// With robust weights the redundancy numbers still sum to residuals minus parameters.
TEST(Redundancy, CountsRobustWeights) {
  PredictedChain chain(20);
  for (const FactorId id : chain.positions) chain.net.SetLoss(id, {Loss::Type::kHuber, 0.5});
  ASSERT_TRUE(Solve(chain.net).converged);
  Marginals marginals(chain.net);
  marginals.ComputeSelectedInverse();
  const CostSummary summary = EvaluateCost(chain.net);
  EXPECT_NEAR(RedundancyNumbers(marginals).sum(),
              static_cast<double>(summary.residuals - summary.parameters), kSumTolerance);
  Marginals side_by_side(chain.net, {.threads = 3});
  side_by_side.ComputeSelectedInverse();
  EXPECT_EQ(RedundancyNumbers(side_by_side), RedundancyNumbers(marginals));
}

}  // namespace dn::solvers_test
