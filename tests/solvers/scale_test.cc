#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <random>

#include "testing/random.h"

namespace dn::solvers_test {

constexpr int kNodes = 2000;  ///< with 10 unknowns each
constexpr int kLoops = 300;
constexpr double kScaleTolerance = 1e-9;  ///< relative; the condition number is below 1e6

using State = Vec<10>;
using Values = Eigen::Matrix<double, 10, 1>;

/// r = (F x_i - x_j) / sigma: a linear transition in which every component decays and is coupled to
/// its neighbour.
class Transition final : public Factor<Transition, 10, State, State> {
 public:
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    Eigen::Matrix<double, 10, 10> F = 0.99 * Eigen::Matrix<double, 10, 10>::Identity();
    for (int i = 0; i + 1 < 10; ++i) F(i, i + 1) = 0.1;
    const Eigen::Map<const Values> x_i(x[0]), x_j(x[1]);
    const Values residual = (F * x_i - x_j) / 0.01;
    std::copy_n(residual.data(), 10, r);
    Put<0>(x, J, F / 0.01);
    Put<1>(x, J, -Eigen::Matrix<double, 10, 10>::Identity() / 0.01);
    return true;
  }
};

/// r = (x_i - x_j + R b) / sigma on the first three components, with the shared block b.
class Loop final : public Factor<Loop, 3, State, State, Vec<3>> {
 public:
  explicit Loop(const Eigen::Matrix3d& R) : R_(R) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const Eigen::Map<const Values> x_i(x[0]), x_j(x[1]);
    const Eigen::Vector3d residual =
        (x_i.head<3>() - x_j.head<3>() + R_ * Eigen::Map<const Eigen::Vector3d>(x[2])) / 0.05;
    std::copy_n(residual.data(), 3, r);
    Eigen::Matrix<double, 3, 10> select = Eigen::Matrix<double, 3, 10>::Zero();
    select.leftCols<3>().setIdentity();
    Put<0>(x, J, select / 0.05);
    Put<1>(x, J, -select / 0.05);
    Put<2>(x, J, R_ / 0.05);
    return true;
  }

 private:
  Eigen::Matrix3d R_;
};

/// r = x / sigma.
class Anchor final : public Factor<Anchor, 10, State> {
 public:
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    for (int i = 0; i < 10; ++i) r[i] = x[0][i];
    Put<0>(x, J, Eigen::Matrix<double, 10, 10>::Identity());
    return true;
  }
};

// A chain with loops between mirrored parts, of the size of a short flight.
TEST(Scale, TwentyThousandUnknowns) {
  std::mt19937 rng(7);
  Network net;
  const auto b = net.AddVector<3>("shared", Eigen::Vector3d(0.1, 0.2, 0.3));
  std::vector<Block<State>> x;
  for (int i = 0; i < kNodes; ++i) {
    x.push_back(net.AddVector<10>("x/" + std::to_string(i), testing::RandomVector<10>(rng, 1.0)));
    if (i > 0) net.Add(Transition{}, x[x.size() - 2], x.back());
    if (i % 20 == 0) net.Add(Anchor{}, x.back());
  }
  std::uniform_int_distribution<std::size_t> position(0, 198), strip(0, 8);
  for (int k = 0; k < kLoops; ++k) {
    const std::size_t s = strip(rng), at = position(rng);
    net.Add(Loop(testing::RandomRotation(rng).toRotationMatrix()), x[200 * s + at],
            x[200 * (s + 1) + 199 - at], b);
  }

  const SolveSummary summary = Solve(net);
  ASSERT_TRUE(summary.converged) << summary.message;
  // Linear, with zero cost at the solution.
  EXPECT_LT(summary.final_cost, 1e-15 * summary.initial_cost);

  Marginals marginals(net);
  EXPECT_EQ(marginals.num_parameters(), 10 * kNodes + 3);
  marginals.ComputeSelectedInverse();
  const auto columns = marginals.SolveColumns({b.id, x[777].id});
  const Eigen::Matrix3d C_bb = columns.Rows(b.id).leftCols<3>();
  EXPECT_LT((marginals.DiagonalBlock(b.id) - C_bb).norm(), kScaleTolerance * C_bb.norm());
  const Eigen::MatrixXd C_xx = columns.Rows(x[777].id).rightCols<10>();
  EXPECT_LT((marginals.DiagonalBlock(x[777].id) - C_xx).norm(), kScaleTolerance * C_xx.norm());
  const auto C_next = marginals.SelectedCovariance(x[778].id, x[777].id);
  ASSERT_TRUE(C_next.has_value());
  EXPECT_LT((*C_next - columns.Rows(x[778].id).rightCols<10>()).norm(),
            kScaleTolerance * C_xx.norm());
}

}  // namespace dn::solvers_test
