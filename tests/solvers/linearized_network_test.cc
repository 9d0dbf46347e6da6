#include <dn/error.h>
#include <dn/solvers/linearized_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/prediction.h>
#include <dn/solvers/score_test.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"
#include "solvers/step_factor.h"

namespace dn::solvers_test {

using testing::MakeVectorPrior;
using testing::Step;

/// A triangle of positions: x2 is constant, one factor has a robust loss, one factor is inactive.
struct Triangle {
  Network net;
  Block<Vec<3>> x[3];
  FactorId robust = -1, idle = -1;

  Triangle() {
    for (int k = 0; k < 3; ++k) {
      x[k] = net.AddVector<3>("x/" + std::to_string(k), Eigen::Vector3d(k, -k, 0.5));
    }
    net.Add(MakeVectorPrior<3>(Eigen::Vector3d(0.1, 0.0, -0.1), 0.5), x[0]);
    robust = AddDifference(0, 1, {4.0, 1.0, 0.0});
    idle = AddDifference(0, 1, {9.0, 9.0, 9.0});
    AddDifference(1, 2, {1.0, -1.0, 0.2});
    net.SetLoss(robust, {Loss::Type::kHuber, 1.0});
    net.SetActive(idle, false);
    net.Hold(x[2]);
  }

  FactorId AddDifference(int a, int b, const Eigen::Vector3d& z) {
    Step factor;
    factor.z = z;
    factor.sigma = 0.5;
    return net.Add(factor, x[a], x[b]);
  }
};

TEST(LinearizedNetwork, RejectsHandlesOfAnotherNetwork) {
  Triangle one, other;
  const LinearizedNetwork linearized(one.net);
  const Marginals marginals(linearized);
  EXPECT_EQ(linearized.Value(one.x[1]), one.net.Value(one.x[1]));
  EXPECT_THROW(linearized.Value(other.x[1]), InvalidInput);
  EXPECT_THROW(marginals.Sigma(other.x[1]), InvalidInput);
  EXPECT_THROW(marginals.Covariance(one.x[0], other.x[1]), InvalidInput);
  const Network copy = one.net;
  EXPECT_EQ(Marginals(copy).Sigma(one.x[1]), marginals.Sigma(one.x[1]));
}

TEST(LinearizedNetwork, RowsAreThoseOfTheActiveFactors) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  ASSERT_EQ(linearized.factors().size(), 3U);
  EXPECT_EQ(linearized.rows(), 9);
  EXPECT_EQ(linearized.parameters(), 6);
  EXPECT_EQ(linearized.FirstColumn(triangle.x[0].id), 0);
  EXPECT_EQ(linearized.FirstColumn(triangle.x[1].id), 3);
  EXPECT_EQ(linearized.FirstColumn(triangle.x[2].id), -1) << "held";
}

TEST(LinearizedNetwork, RobustWeightsScaleTheRows) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  Eigen::VectorXd r;
  ASSERT_TRUE(triangle.net.EvaluateFactor(triangle.robust, &r));
  const double weight = 1.0 / r.norm();  // Huber loss of width 1
  const LinearizedNetwork::FactorRows& rows = linearized.factors()[1];
  ASSERT_EQ(rows.factor, triangle.robust);
  EXPECT_LT((linearized.residual().segment(rows.first, rows.count) - std::sqrt(weight) * r).norm(),
            1e-14);
}

TEST(LinearizedNetwork, ProductsAreThoseOfOneMatrix) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net, 2);
  const Eigen::MatrixXd J = linearized.Times(Eigen::MatrixXd::Identity(6, 6));
  EXPECT_LT((linearized.TransposeTimes(Eigen::MatrixXd::Identity(9, 9)) - J.transpose()).norm(),
            1e-14);
  const Marginals marginals(linearized);
  const Eigen::MatrixXd N = J.transpose() * J;
  EXPECT_LT((marginals.Solve(Eigen::MatrixXd::Identity(6, 6)) - N.inverse()).norm(), 1e-12);
  const Eigen::MatrixXd M = marginals.Project(Eigen::MatrixXd::Identity(9, 9));
  EXPECT_LT((M * M - M).norm(), 1e-12) << "M must be a projection";
  EXPECT_LT((J.transpose() * M).norm(), 1e-12) << "M must be orthogonal to the unknowns";
  EXPECT_NEAR(M.trace(), 3.0, 1e-12) << "the trace of M must be the redundancy";
  const Eigen::MatrixXd many = Eigen::MatrixXd::Random(9, 40);
  EXPECT_LT((marginals.Project(many) - M * many).norm(), 1e-12);
  EXPECT_THROW(marginals.Project(Eigen::MatrixXd::Zero(8, 1)), InvalidInput);
}

// At the minimum the residual contains nothing that the unknowns could still absorb.
TEST(LinearizedNetwork, ResidualOfASolvedNetworkIsItsOwnProjection) {
  Triangle triangle;
  triangle.net.SetLoss(triangle.robust, {});
  SolveOptions options;
  options.function_tolerance = 1e-16;
  options.initial_trust_region_radius = 1e13;  // the problem is linear, so damping is not needed
  ASSERT_TRUE(Solve(triangle.net, options).converged);
  const LinearizedNetwork linearized(triangle.net);
  const Eigen::MatrixXd projected = Marginals(linearized).Project(linearized.residual());
  EXPECT_LT((projected - linearized.residual()).norm(), 1e-9);
}

TEST(LinearizedNetwork, RowsHaveNames) {
  Triangle triangle;
  triangle.net.Tag(triangle.robust, {"odometer", {{"x", "shift"}, {"y", "shift"}, {"turn"}}}, 7.5);
  const LinearizedNetwork linearized(triangle.net);
  const LinearizedNetwork::Row row = FindRow(linearized, 4);
  EXPECT_EQ(row.factor, triangle.robust);
  EXPECT_EQ(row.residual, 1);
  EXPECT_EQ(row.channel, "odometer shift");
  EXPECT_EQ(row.axis, "y");
  EXPECT_EQ(row.t_s, 7.5);
  EXPECT_EQ(FindRow(linearized, 0).channel, "") << "no tag";
  EXPECT_EQ(FindRow(linearized, 8).axis, "2");
  EXPECT_THROW(FindRow(linearized, 9), InvalidInput);
}

// The snapshot does not change if the network is changed or destroyed afterwards.
TEST(LinearizedNetwork, IsASnapshot) {
  auto triangle = std::make_unique<Triangle>();
  const Block<Vec<3>> x0 = triangle->x[0];
  const FactorId idle = triangle->idle;
  const LinearizedNetwork first(triangle->net);
  triangle->net.SetValue(x0, Eigen::Vector3d(7.0, 7.0, 7.0));
  triangle->net.SetActive(idle, true);
  const LinearizedNetwork second(triangle->net);
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): copying is what is tested
  const LinearizedNetwork copy = first;
  triangle.reset();
  EXPECT_EQ(copy.Value(x0), Eigen::Vector3d(0.0, 0.0, 0.5));
  EXPECT_EQ(second.Value(x0), Eigen::Vector3d(7.0, 7.0, 7.0));
  EXPECT_FALSE(copy.FindRows(idle));
  ASSERT_TRUE(second.FindRows(idle));
  // 2 (x1 - x0 - 9) with the values stored in each snapshot
  EXPECT_LT((copy.EvaluateFactorAt(idle).residual - Eigen::Vector3d(-16.0, -20.0, -18.0)).norm(),
            1e-14);
  EXPECT_LT((second.EvaluateFactorAt(idle).residual - Eigen::Vector3d(-30.0, -34.0, -31.0)).norm(),
            1e-14);
  EXPECT_EQ(copy.EvaluateFactorAt(idle).weight, 0.0);
}

TEST(LinearizedNetwork, AFactorByItselfIsWithoutItsRobustWeight) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  ASSERT_TRUE(triangle.net.EvaluateFactor(triangle.robust, &r, &J));
  const LinearizedNetwork::Factor factor = linearized.EvaluateFactorAt(triangle.robust);
  EXPECT_LT((factor.residual - r).norm(), 1e-14);
  ASSERT_EQ(factor.jacobian.size(), 2U);
  EXPECT_EQ(factor.jacobian[1].first, triangle.x[1].id);
  EXPECT_LT((factor.jacobian[1].second - J[1]).norm(), 1e-14);
  EXPECT_NEAR(factor.weight, 1.0 / r.norm(), 1e-14) << "Huber of width 1";
}

/// A chain of positions in which the stated noise of every second factor is multiplied by `ratio`.
struct Stated {
  Network net;
  std::vector<FactorId> scaled;
  Block<Vec<3>> x[6];

  explicit Stated(double ratio) {
    for (int k = 0; k < 6; ++k) {
      x[k] = net.AddVector<3>("x/" + std::to_string(k), Eigen::Vector3d(0.1 * k, 0.0, -0.2));
      const double sigma = 0.5 * (k % 2 == 0 ? ratio : 1.0);
      const FactorId id =
          net.Add(MakeVectorPrior<3>(Eigen::Vector3d(0.3, 0.1 * k, 1.0), sigma), x[k]);
      if (k % 2 == 0) scaled.push_back(id);
      Step step;
      step.sigma = 0.5;
      step.z = Eigen::Vector3d(0.2, 0.1, -0.1 * k);
      if (k > 0) net.Add(step, x[k - 1], x[k]);
    }
  }

  LinearizedNetwork Scaled(double ratio) const {
    const LinearizedNetwork linearized(net);
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(linearized.rows());
    for (const FactorId id : scaled) {
      const LinearizedNetwork::FactorRows rows = *linearized.FindRows(id);
      scale.segment(rows.first, rows.count).setConstant(1.0 / ratio);
    }
    return linearized.Scaled(scale);
  }

  /// Returns a drift of the scaled positions, in sigmas of size `sigma`.
  EffectModel Drift(double sigma) const {
    EffectModel effect;
    for (const FactorId id : scaled) {
      effect.push_back(
          {id, Eigen::MatrixXd(static_cast<double>(id) / sigma * Eigen::Matrix3d::Identity())});
    }
    return effect;
  }
};

// Compares all results of the snapshot; the derivatives of the effects are given as before.
TEST(ScaledNetwork, IsTheNetworkWithThatNoise) {
  constexpr double kRatio = 1.7, kTolerance = 1e-12;
  const Stated before(1.0), wanted(kRatio);
  Marginals a(before.Scaled(kRatio)), b{LinearizedNetwork(wanted.net)};
  EXPECT_LT((a.linearized().residual() - b.linearized().residual()).norm(), kTolerance);
  EXPECT_LT((a.Covariance(before.x[3].id) - b.Covariance(wanted.x[3].id)).norm(), kTolerance);
  EXPECT_NEAR(a.LogDeterminant(), b.LogDeterminant(), kTolerance);
  const JointScore of_a = ScoreEffects(a, {before.Drift(0.5)}, {before.x[3].id});
  const JointScore of_b = ScoreEffects(b, {wanted.Drift(0.5 * kRatio)}, {wanted.x[3].id});
  EXPECT_LT((of_a.s - of_b.s).norm(), 1e-11);
  EXPECT_LT((of_a.A - of_b.A).norm(), 1e-11);
  EXPECT_LT((of_a.shift - of_b.shift).norm(), 1e-11);
  EXPECT_NEAR(TestEffects(a, {before.Drift(0.5)}).front().statistic,
              TestEffects(b, {wanted.Drift(0.5 * kRatio)}).front().statistic, 1e-11);
  a.ComputeSelectedInverse();
  b.ComputeSelectedInverse();
  EXPECT_LT((RedundancyNumbers(a) - RedundancyNumbers(b)).norm(), kTolerance);
  const FactorId factor = before.scaled[1];
  EXPECT_NEAR(PredictFactor(a, factor).statistic, PredictFactor(b, factor).statistic, 1e-11);
}

TEST(ScaledNetwork, LeavesTheFirstAsItIs) {
  const Stated stated(1.0);
  const LinearizedNetwork linearized(stated.net);
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): what it was before
  const Eigen::VectorXd before = linearized.residual();
  const LinearizedNetwork half =
      linearized.Scaled(Eigen::VectorXd::Constant(linearized.rows(), 0.5));
  const LinearizedNetwork quarter = half.Scaled(Eigen::VectorXd::Constant(linearized.rows(), 0.5));
  EXPECT_EQ(linearized.residual(), before);
  EXPECT_EQ(linearized.row_scale(), Eigen::VectorXd::Ones(linearized.rows()));
  EXPECT_EQ(quarter.residual(), 0.25 * before);
  EXPECT_EQ(quarter.row_scale(), Eigen::VectorXd::Constant(linearized.rows(), 0.25));
}

// An effect that equals an unknown is absorbed, whatever the scale and weight of a row are.
TEST(ScaledNetwork, EffectsHaveTheRobustWeightAsWell) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  Eigen::VectorXd scale(linearized.rows());
  for (Eigen::Index row = 0; row < scale.size(); ++row) scale[row] = 0.4 + 0.3 * (row % 4);
  EffectModel as_unknown;
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    for (const auto& [block, J] : linearized.EvaluateFactorAt(rows.factor).jacobian) {
      if (block == triangle.x[1].id) as_unknown.push_back({rows.factor, J});
    }
  }
  ASSERT_EQ(as_unknown.size(), 2U);
  const Marginals marginals(linearized.Scaled(scale));
  EXPECT_EQ(TestEffects(marginals, {as_unknown}).front().dof, 0);
  const JointScore score = ScoreEffects(marginals, {as_unknown}, {triangle.x[1].id});
  EXPECT_LT((score.shift - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(ScaledNetwork, AScaleThatCannotBeIsNamed) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(linearized.rows());
  EXPECT_THROW(linearized.Scaled(scale.head(3)), InvalidInput);
  scale[2] = 0.0;
  EXPECT_THROW(linearized.Scaled(scale), InvalidInput);
  scale[2] = std::nan("");
  EXPECT_THROW(linearized.Scaled(scale), InvalidInput);
}

TEST(LinearizedNetwork, SizesThatDoNotFitAreNamed) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  EXPECT_THROW(linearized.Times(Eigen::VectorXd::Zero(5)), InvalidInput);
  EXPECT_THROW(linearized.TransposeTimes(Eigen::VectorXd::Zero(10)), InvalidInput);
  EXPECT_THROW(Marginals(triangle.net).Solve(Eigen::MatrixXd::Zero(5, 1)), InvalidInput);
}

}  // namespace dn::solvers_test
