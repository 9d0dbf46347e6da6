#include <dn/error.h>
#include <dn/solvers/linearized_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <vector>

#include "solvers/pose_graph.h"

namespace dn {
namespace {

using testing::MakeVectorPrior;

struct Difference : AutoFactor<Difference, 3, Vec<3>, Vec<3>> {
  Eigen::Vector3d z;
  template <class T>
  bool Residual(const T* a, const T* b, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = 2.0 * (b[i] - a[i] - z[i]);
    return true;
  }
};

/// A triangle of positions; x2 is held, one factor has a robust loss, one is not active.
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
    Difference factor;
    factor.z = z;
    return net.Add(factor, x[a], x[b]);
  }
};

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
  const double weight = 1.0 / r.norm();  // Huber of width 1
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
  EXPECT_LT((M * M - M).norm(), 1e-12) << "a projection";
  EXPECT_LT((J.transpose() * M).norm(), 1e-12) << "onto what the unknowns cannot follow";
  EXPECT_NEAR(M.trace(), 3.0, 1e-12) << "the redundancy";
}

// At the minimum nothing of the residual is left to fit.
TEST(LinearizedNetwork, ResidualOfASolvedNetworkIsItsOwnProjection) {
  Triangle triangle;
  triangle.net.SetLoss(triangle.robust, {});
  SolveOptions options;
  options.function_tolerance = 1e-16;
  options.initial_trust_region_radius = 1e13;  // a linear problem: no damping
  ASSERT_TRUE(Solve(triangle.net, options).converged);
  const LinearizedNetwork linearized(triangle.net);
  const Eigen::MatrixXd projected = Marginals(linearized).Project(linearized.residual());
  EXPECT_LT((projected - linearized.residual()).norm(), 1e-9);
}

TEST(LinearizedNetwork, RowsHaveNames) {
  Triangle triangle;
  triangle.net.Tag(triangle.robust, {"odometer", {{"x", "shift"}, {"y", "shift"}, {"turn"}}}, 7.5);
  const LinearizedNetwork linearized(triangle.net);
  const LinearizedNetwork::Row row = linearized.RowAt(4);
  EXPECT_EQ(row.factor, triangle.robust);
  EXPECT_EQ(row.residual, 1);
  EXPECT_EQ(row.channel, "odometer shift");
  EXPECT_EQ(row.axis, "y");
  EXPECT_EQ(row.t_s, 7.5);
  EXPECT_EQ(linearized.RowAt(0).channel, "") << "no tag";
  EXPECT_EQ(linearized.RowAt(8).axis, "2");
  EXPECT_THROW(linearized.RowAt(9), InvalidInput);
}

// What is changed, or gone, afterwards is not seen.
TEST(LinearizedNetwork, IsASnapshot) {
  auto triangle = std::make_unique<Triangle>();
  const Block<Vec<3>> x0 = triangle->x[0];
  const FactorId idle = triangle->idle;
  const LinearizedNetwork first(triangle->net);
  triangle->net.SetValue(x0, Eigen::Vector3d(7.0, 7.0, 7.0));
  triangle->net.SetActive(idle, true);
  const LinearizedNetwork second(triangle->net);
  const LinearizedNetwork copy = first;
  triangle.reset();
  EXPECT_EQ(copy.Value(x0), Eigen::Vector3d(0.0, 0.0, 0.5));
  EXPECT_EQ(second.Value(x0), Eigen::Vector3d(7.0, 7.0, 7.0));
  EXPECT_FALSE(copy.RowsOf(idle));
  ASSERT_TRUE(second.RowsOf(idle));
  // 2 (x1 - x0 - 9) of the x that each of them holds
  EXPECT_LT((copy.FactorAt(idle).residual - Eigen::Vector3d(-16.0, -20.0, -18.0)).norm(), 1e-14);
  EXPECT_LT((second.FactorAt(idle).residual - Eigen::Vector3d(-30.0, -34.0, -31.0)).norm(), 1e-14);
  EXPECT_EQ(copy.FactorAt(idle).weight, 0.0);
}

TEST(LinearizedNetwork, AFactorByItselfIsWithoutItsRobustWeight) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  ASSERT_TRUE(triangle.net.EvaluateFactor(triangle.robust, &r, &J));
  const LinearizedNetwork::Factor factor = linearized.FactorAt(triangle.robust);
  EXPECT_LT((factor.residual - r).norm(), 1e-14);
  ASSERT_EQ(factor.jacobian.size(), 2U);
  EXPECT_EQ(factor.jacobian[1].first, triangle.x[1].id);
  EXPECT_LT((factor.jacobian[1].second - J[1]).norm(), 1e-14);
  EXPECT_NEAR(factor.weight, 1.0 / r.norm(), 1e-14) << "Huber of width 1";
}

TEST(LinearizedNetwork, SizesThatDoNotFitAreNamed) {
  const Triangle triangle;
  const LinearizedNetwork linearized(triangle.net);
  EXPECT_THROW(linearized.Times(Eigen::VectorXd::Zero(5)), InvalidInput);
  EXPECT_THROW(linearized.TransposeTimes(Eigen::VectorXd::Zero(10)), InvalidInput);
  EXPECT_THROW(Marginals(triangle.net).Solve(Eigen::MatrixXd::Zero(5, 1)), InvalidInput);
}

}  // namespace
}  // namespace dn
