#include <dn/error.h>
#include <dn/solvers/linearized_network.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

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
  const Marginals marginals(triangle.net);
  const Eigen::MatrixXd N = J.transpose() * J;
  EXPECT_LT((marginals.Solve(Eigen::MatrixXd::Identity(6, 6)) - N.inverse()).norm(), 1e-12);
  const Eigen::MatrixXd M = linearized.Project(Eigen::MatrixXd::Identity(9, 9), marginals);
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
  const Eigen::MatrixXd projected =
      linearized.Project(linearized.residual(), Marginals(triangle.net));
  EXPECT_LT((projected - linearized.residual()).norm(), 1e-9);
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
