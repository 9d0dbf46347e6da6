#include <dn/error.h>
#include <dn/solvers/weak_directions.h>
#include <dn/symmetric_eigen.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <string>

#include "solvers/one_by_one.h"
#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using ::testing::HasSubstr;
using testing::MakePoseGraph;
using testing::MakeVectorPrior;
using testing::OneByOne;
using testing::PoseGraph;

/// r = (a + b) / sigma.
struct Sum : AutoFactor<Sum, 1, Vec<1>, Vec<1>> {
  double sigma = 1.0;
  template <class T>
  bool Residual(const T* a, const T* b, T* r) const {
    r[0] = (a[0] + b[0]) / sigma;
    return true;
  }
};

// The sum of a and b has sigma 0.01, each of them sigma 1: N = [10001 10000; 10000 10001]. With a
// unit diagonal its eigenvalues are 1 -+ 10000/10001. The weak direction is the difference.
TEST(WeakDirections, OfTwoUnknownsWhoseSumIsMeasured) {
  Network net;
  const auto a = net.AddVector<1>("a", OneByOne(0.0)), b = net.AddVector<1>("b", OneByOne(0.0));
  net.SetLabel(a.id, {"antenna", {"up"}, "m", 1.0, std::numeric_limits<double>::quiet_NaN()});
  net.SetLabel(b.id, {"position", {"up"}, "m", 1.0, 381000.0});
  net.Add(MakeVectorPrior<1>(OneByOne(0.0), 1.0), a);
  net.Add(MakeVectorPrior<1>(OneByOne(0.0), 1.0), b);
  Sum sum;
  sum.sigma = 0.01;
  net.Add(sum, a, b);
  const auto weak = WeakDirections(Marginals(net), 5);
  ASSERT_EQ(weak.size(), 2U) << "as many as there are unknowns";
  EXPECT_NEAR(weak[0].information, 1.0 / 10001.0, 1e-12);
  EXPECT_NEAR(weak[1].information, 20001.0 / 10001.0, 1e-12);
  const double step_a = weak[0].one_sigma.at(a.id)[0], step_b = weak[0].one_sigma.at(b.id)[0];
  EXPECT_NEAR(step_a, -step_b, 1e-9);
  EXPECT_NEAR(std::abs(step_a), 1.0 / std::sqrt(2.0), 1e-9) << "a - b has the sigma sqrt(2)";
  EXPECT_THAT(weak[0].text, HasSubstr("antenna up (0.71)"));
  EXPECT_THAT(weak[0].text, HasSubstr("position up, 381000.0 s (0.71)"));
  ASSERT_EQ(weak[0].shares.size(), 2U);
  EXPECT_NEAR(weak[0].shares[0].weight, std::sqrt(0.5), 1e-9);
}

// Compares with the dense eigenvalues of a pose graph that only a weak prior constrains.
TEST(WeakDirections, AreTheSmallestEigenvaluesOfTheScaledNormalMatrix) {
  const PoseGraph graph = MakePoseGraph(5, {.noise = 1.0});
  const Marginals marginals(graph.network);
  const int n = marginals.num_parameters();
  const LinearizedNetwork& linearized = marginals.linearized();
  const Eigen::MatrixXd J = linearized.Times(Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd scale = J.colwise().norm().cwiseInverse();
  const Eigen::MatrixXd scaled = J * scale.asDiagonal();
  const SymmetricEigen dense(scaled.transpose() * scaled);
  const auto weak = WeakDirections(marginals, 10);
  ASSERT_EQ(weak.size(), 10U);
  for (std::size_t i = 0; i < weak.size(); ++i) {
    EXPECT_NEAR(weak[i].information / dense.values[static_cast<Eigen::Index>(i)], 1.0, 1e-6);
    Eigen::VectorXd step(n);
    for (const auto& [block, part] : weak[i].one_sigma) {
      step.segment(linearized.FirstColumn(block), part.size()) = part;
    }
    EXPECT_NEAR((J * step).norm(), 1.0, 1e-9) << "one sigma changes the residuals by one";
  }
}

// All directions together give the covariance.
TEST(WeakDirections, SumToTheCovariance) {
  Network net;
  const auto x = net.AddVector<3>("x", Eigen::Vector3d::Zero());
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 0.5), x);
  const auto y = net.AddVector<3>("y", Eigen::Vector3d::Zero());
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 2.0), y);
  const Marginals marginals(net);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const WeakDirection& direction : WeakDirections(marginals, 6)) {
    const Eigen::VectorXd& part = direction.one_sigma.at(y.id);
    sum += part * part.transpose();
  }
  EXPECT_LT((sum - marginals.Covariance(y)).norm(), 1e-12);
  EXPECT_THROW(WeakDirections(marginals, 0), InvalidInput);
}

}  // namespace dn::solvers_test
