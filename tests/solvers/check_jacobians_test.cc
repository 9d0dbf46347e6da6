#include <dn/error.h>
#include <dn/solvers/check_jacobians.h>
#include <dn/solvers/solve.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

/// A straight line seen at x; the derivative by the slope has the wrong size if `factor` is not 1.
struct Line final : Factor<Line, 1, Vec<2>> {
  double x_m, y_m, factor;
  Line(double x, double y, double wrong_factor) : x_m(x), y_m(y), factor(wrong_factor) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    r[0] = (x[0][0] + x_m * x[0][1] - y_m) / 0.1;
    Put<0>(x, J, Eigen::RowVector2d(10.0, factor * 10.0 * x_m));
    return true;
  }
};

/// An angle stored as a number, whose PlusJacobian is wrong by a factor. Checks of the kind do not
/// see the factor, because it depends on the value.
struct Angle {
  using Value = double;
  static constexpr int kSize = 1, kTangentSize = 1;
  static void Plus(const double* x, const double* d, double* y) { *y = *x + *d; }
  static void Minus(const double* y, const double* x, double* d) { *d = *y - *x; }
  static void PlusJacobian(const double* x, double* J) { *J = *x > 1.0 ? 3.0 : 1.0; }
};

TEST(CheckJacobians, FindsNothingInAPoseGraph) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    testing::PoseGraph graph = testing::MakePoseGraph(seed, {.noise = 1.0});
    EXPECT_THAT(CheckJacobians(graph.network, {.threads = 2}), IsEmpty());
  }
}

TEST(CheckJacobians, NamesFactorBlockAndEntry) {
  for (const double wrong : {-1.0, 3.0, 0.0, 1.01}) {
    Network net;
    const auto p = net.AddVector<2>("line", {0.3, -0.2});
    net.Add(Line(2.0, 1.0, 1.0), p);
    const FactorId id = net.Add(Line(7.0, 1.0, wrong), p);
    net.Tag(id, "levelling", 12.5);
    const std::vector<JacobianFault> faults = CheckJacobians(net);
    ASSERT_EQ(faults.size(), 1U) << wrong;
    EXPECT_EQ(faults[0].factor, id);
    EXPECT_EQ(faults[0].block, p.id);
    EXPECT_EQ(faults[0].row, 0);
    EXPECT_EQ(faults[0].column, 1);
    EXPECT_NEAR(faults[0].computed, wrong * 70.0, 1e-9);
    EXPECT_NEAR(faults[0].numerical, 70.0, 1e-6);
    EXPECT_THAT(faults[0].text, HasSubstr("levelling, 12.500 s"));
    EXPECT_THAT(faults[0].text, HasSubstr("block 'line' in row 0, column 1"));
  }
}

TEST(CheckJacobians, FindsAWrongPlusJacobian) {
  Network net;
  const auto a = net.AddBlock<Angle>("angle", 0.5);
  net.Add([](const auto& x) { return x - 0.7; }, Noise<1>::Sigma(0.1), a);
  EXPECT_THAT(CheckJacobians(net), IsEmpty());
  net.SetValue(a, 2.0);
  ASSERT_EQ(CheckJacobians(net).size(), 1U);
  EXPECT_NEAR(CheckJacobians(net)[0].computed, 30.0, 1e-9);
}

// Numbers of very different sizes, a function with a narrow domain, one that is not smooth.
TEST(CheckJacobians, AcceptsRightJacobiansOfAnySize) {
  Network net;
  const auto large = net.AddVector<3>("ecef", {4.2e6, 0.6e6, 4.7e6});
  net.Add([](const auto& x) { return (x - Eigen::Vector3d(4.1e6, 0.5e6, 4.8e6)).norm(); },
          Noise<1>::Sigma(1e-3), large);
  const auto small = net.AddScalar("bias", 3e-8);
  net.Add([](const auto& x) { return 1e3 * x * x + x; }, Noise<1>::Sigma(1e-9), small);
  const auto narrow = net.AddScalar("narrow", 1e-5);
  net.Add(
      [](const auto& x) {
        using std::log;
        return log(x);
      },
      Noise<1>::Sigma(1.0), narrow);
  const auto kink = net.AddScalar("kink", 0.0);
  net.Add(
      [](const auto& x) {
        using std::abs;
        return abs(x);
      },
      Noise<1>::Sigma(1.0), kink);
  EXPECT_THAT(CheckJacobians(net), IsEmpty());
}

// Larger steps would cross the pole.
TEST(CheckJacobians, AcceptsAFunctionNearItsPole) {
  Network net;
  const auto x = net.AddScalar("x", 0.0);
  net.Add([](const auto& value) { return 1.0 / (1e-9 + value); }, Noise<1>::Sigma(1.0), x);
  EXPECT_THAT(CheckJacobians(net), IsEmpty());
}

TEST(CheckJacobians, LeavesOutConstantBlocksAndInactiveFactors) {
  Network net;
  const auto p = net.AddVector<2>("line", {0.3, -0.2});
  const FactorId id = net.Add(Line(7.0, 1.0, 3.0), p);
  net.Hold(p);
  EXPECT_THAT(CheckJacobians(net), IsEmpty());
  net.Hold(p, false);
  net.SetActive(id, false);
  EXPECT_THAT(CheckJacobians(net), IsEmpty());
}

TEST(CheckJacobians, ChecksAFewFactorsPerClassOnRequest) {
  Network net;
  const auto p = net.AddVector<2>("line", {0.3, -0.2});
  for (int k = 1; k < 5; ++k) net.Add(Line(k, 1.0, 3.0), p);
  EXPECT_EQ(CheckJacobians(net).size(), 4U);
  EXPECT_EQ(CheckJacobians(net, {.most_per_class = 1}).size(), 1U);
  const std::vector<JacobianFault> ends = CheckJacobians(net, {.most_per_class = 2});
  ASSERT_EQ(ends.size(), 2U);
  EXPECT_EQ(ends[0].factor, 0);
  EXPECT_EQ(ends[1].factor, 3);
  EXPECT_THROW(CheckJacobians(net, {.most_per_class = -1}), InvalidConfig);
  EXPECT_THROW(CheckJacobians(net, {.tolerance = 0.0}), InvalidConfig);
  EXPECT_THROW(CheckJacobians(net, {.threads = 0}), InvalidConfig);
}

TEST(Solve, ChecksJacobiansOnRequest) {
  Network net;
  const auto p = net.AddVector<2>("line", {0.3, -0.2});
  for (int k = 0; k < 5; ++k) net.Add(Line(k, 1.0 + k, 3.0), p);
  EXPECT_THAT([&] { (void)Solve(net, {.check_jacobians = true}); },
              ThrowsMessage<InvalidInput>(HasSubstr("its Jacobian of block 'line'")));
  EXPECT_EQ(net.Value(p), Eigen::Vector2d(0.3, -0.2));
  EXPECT_NO_THROW((void)Solve(net, {.check_jacobians = false}));
}

}  // namespace dn::solvers_test
