#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "solvers/one_by_one.h"
#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using testing::MakePoseGraph;
using testing::MakeVectorPrior;
using testing::OneByOne;
using testing::PoseGraph;

// Without noise the minimum is the truth; the tolerance allows for the convergence of the last
// step.
constexpr double kTruthTolerance = 1e-8;
// One step solves a linear network, up to the damping 1e-6 / radius and rounding.
constexpr double kLinearTolerance = 1e-11;

/// r = (x_j - x_i - z) / sigma: a levelled height difference.
struct HeightDifference : AutoFactor<HeightDifference, 1, Vec<1>, Vec<1>> {
  double z_m = 0.0, sigma_m = 1.0;

  template <class T>
  bool Residual(const T* x_i, const T* x_j, T* r) const {
    r[0] = (x_j[0] - x_i[0] - z_m) / sigma_m;
    return true;
  }
};

/// r = sqrt(x) - 1, undefined below zero.
struct SquareRoot : AutoFactor<SquareRoot, 1, Vec<1>> {
  template <class T>
  bool Residual(const T* x, T* r) const {
    using std::sqrt;
    if (x[0] < T(0.0)) return false;
    r[0] = sqrt(x[0]) - T(1.0);
    return true;
  }
};

testing::VectorPrior<1> Prior(double z) { return MakeVectorPrior<1>(OneByOne(z), 1.0); }

// A levelled triangle with a misclosure of 6 mm: each of the three equally weighted differences is
// corrected by 2 mm.
TEST(Solve, AdjustsALevellingTriangle) {
  Network net;
  const auto a = net.AddVector<1>("a", OneByOne(100.0));
  const auto b = net.AddVector<1>("b", OneByOne(0.0));
  const auto c = net.AddVector<1>("c", OneByOne(0.0));
  net.Hold(a);
  HeightDifference f;
  f.sigma_m = 0.001;
  f.z_m = 1.000;
  net.Add(f, a, b);
  f.z_m = 2.000;
  net.Add(f, b, c);
  f.z_m = -2.994;
  net.Add(f, c, a);

  const SolveSummary summary = Solve(net);
  EXPECT_TRUE(summary.converged) << summary.message;
  EXPECT_NEAR(net.Value(b)[0], 100.998, kLinearTolerance * 100.0);
  EXPECT_NEAR(net.Value(c)[0], 102.996, kLinearTolerance * 100.0);
  EXPECT_NEAR(summary.final_cost, 0.5 * 3 * 4.0, 1e-9);  // three residuals of 2 sigma
  EXPECT_EQ(net.Value(a)[0], 100.0);
}

TEST(Solve, RecoversTheTruthWithoutNoise) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    PoseGraph graph = MakePoseGraph(seed);
    const SolveSummary summary = Solve(graph.network);
    ASSERT_TRUE(summary.converged) << summary.message;
    EXPECT_LT(summary.final_cost, 1e-12);
    EXPECT_GT(summary.initial_cost, 1.0);
    for (std::size_t i = 0; i < graph.p_mb.size(); ++i) {
      EXPECT_LT((graph.network.Value(graph.p_mb[i]) - graph.p_mb_true[i]).norm(), kTruthTolerance);
      EXPECT_LT(Log(Eigen::Quaterniond(graph.network.Value(graph.q_mb[i]).conjugate() *
                                       graph.q_mb_true[i]))
                    .norm(),
                kTruthTolerance);
    }
    EXPECT_LT(Log(Eigen::Quaterniond(graph.network.Value(graph.q_bs).conjugate() * graph.q_bs_true))
                  .norm(),
              kTruthTolerance);
  }
}

TEST(Solve, TwoThreadsGiveTheSameSolution) {
  PoseGraph one = MakePoseGraph(3, {.noise = 1.0}), two = MakePoseGraph(3, {.noise = 1.0});
  EXPECT_TRUE(Solve(one.network).converged);
  SolveOptions options;
  options.threads = 2;
  EXPECT_TRUE(Solve(two.network, options).converged);
  for (std::size_t i = 0; i < one.p_mb.size(); ++i) {
    EXPECT_LT((one.network.Value(one.p_mb[i]) - two.network.Value(two.p_mb[i])).norm(),
              kTruthTolerance);
  }
}

TEST(Solve, LeavesInactiveFactorsOutAndUnusedBlocksAlone) {
  Network net;
  const auto x = net.AddVector<1>("x", OneByOne(0.0));
  const auto unused = net.AddVector<1>("unused", OneByOne(7.0));
  net.Add(Prior(1.0), x);
  const FactorId outlier = net.Add(Prior(100.0), x);
  net.SetActive(net.Add(Prior(3.0), unused), false);
  net.SetActive(outlier, false);
  EXPECT_TRUE(Solve(net).converged);
  EXPECT_NEAR(net.Value(x)[0], 1.0, kLinearTolerance);
  EXPECT_EQ(net.Value(unused)[0], 7.0);

  const CostSummary summary = EvaluateCost(net);
  EXPECT_NEAR(summary.cost, 0.0, 1e-20);
  EXPECT_EQ(summary.residuals, 1);
  EXPECT_EQ(summary.parameters, 1);
}

// The message names sigma_tolerance only if that was set.
TEST(Solve, NamesTheToleranceThatEndedIt) {
  for (const int blocks : {1, 99, 100, 300}) {
    for (const double sigma_tolerance : {0.0, 1e-3}) {
      Network net;
      for (int k = 0; k < blocks; ++k) {
        const auto x = net.AddScalar(std::to_string(k), 1.0);
        net.Add([](const auto& v) { return v - 2.0; }, Noise<1>::Sigma(1e-3), x);
      }
      const SolveSummary summary = Solve(net, {.sigma_tolerance = sigma_tolerance});
      EXPECT_TRUE(summary.converged);
      if (sigma_tolerance == 0.0) {
        EXPECT_EQ(summary.message.find("sigma_tolerance"), std::string::npos) << summary.message;
      }
      EXPECT_FALSE(summary.message.empty());
    }
  }
}

TEST(Solve, HasNoCostWhereAFactorIsUndefined) {
  for (const int blocks : {1, 120}) {
    Network net;
    for (int k = 0; k < blocks; ++k) {
      const auto x = net.AddScalar(std::to_string(k), -1.0);
      net.Add(
          [](const auto& v) {
            using std::log;
            return log(v);
          },
          Noise<1>::Sigma(1.0), x);
    }
    const SolveSummary summary = Solve(net);
    EXPECT_FALSE(summary.converged);
    EXPECT_TRUE(std::isnan(summary.final_cost));
    EXPECT_NE(summary.message.find("factor 0"), std::string::npos) << summary.message;
  }
}

// Huber's loss given as a function of one's own: the same solution and covariance by both solvers.
TEST(Solve, TakesALossOfOnesOwn) {
  const Loss own = Loss::Own([](double s) -> std::array<double, 2> {
    const double r = std::sqrt(s);
    return s <= 1.0 ? std::array{s, 1.0} : std::array{2.0 * r - 1.0, 1.0 / r};
  });
  std::array<double, 2> values, sigmas;
  for (const int blocks : {1, 120}) {
    for (const bool is_own : {false, true}) {
      Network net;
      std::vector<Block<dn::Scalar>> x;
      for (int k = 0; k < blocks; ++k) {
        x.push_back(net.AddScalar("x/" + std::to_string(k), 0.5));
        for (const double z : {0.0, 0.1, 10.0}) {
          const FactorId id =
              net.Add([z](const auto& v) { return v - z; }, Noise<1>::Sigma(1.0), x.back());
          net.SetLoss(id, is_own ? own : Loss::Huber(1.0));
        }
      }
      EXPECT_TRUE(Solve(net).converged);
      values[is_own ? 1 : 0] = net.Value(x.back());
      sigmas[is_own ? 1 : 0] = MarginalSigma(net, x.back());
    }
    EXPECT_NEAR(values[0], values[1], 1e-9);
    EXPECT_NEAR(sigmas[0], sigmas[1], 1e-9);
  }
  Network net;
  const auto x = net.AddScalar("x", 0.0);
  const FactorId id = net.Add([](const auto& v) { return v; }, Noise<1>::Sigma(1.0), x);
  EXPECT_THROW(net.SetLoss(id, Loss::Own({})), InvalidInput);
}

// Two observations of 0 and one of 10 with Huber loss of width 1: 2 x = 1.
TEST(Solve, HuberLossBoundsTheInfluenceOfAnOutlier) {
  Network net;
  const auto x = net.AddVector<1>("x", OneByOne(4.0));
  for (const double z : {0.0, 0.0, 10.0}) {
    net.SetLoss(net.Add(Prior(z), x), {Loss::Type::kHuber, 1.0});
  }
  const SolveSummary summary = Solve(net);
  EXPECT_TRUE(summary.converged);
  EXPECT_NEAR(net.Value(x)[0], 0.5, 1e-5);  // reweighting converges linearly, to 1e-10 of the cost
  // The values of rho are 0.25, 0.25 and 2 * 9.5 - 1.
  EXPECT_NEAR(summary.final_cost, 0.5 * (0.25 + 0.25 + 18.0), 1e-8);
  EXPECT_NEAR(EvaluateCost(net, 2).cost, summary.final_cost, 1e-12);
}

TEST(Solve, EvaluateCostAgreesWithTheReportUnderCauchyLoss) {
  PoseGraph graph = MakePoseGraph(11, {.noise = 3.0});
  for (const FactorId id : graph.relative) graph.network.SetLoss(id, {Loss::Type::kCauchy, 2.0});
  const double initial = EvaluateCost(graph.network).cost;
  const SolveSummary summary = Solve(graph.network);
  EXPECT_NEAR(initial, summary.initial_cost, 1e-12 * initial);
  EXPECT_NEAR(EvaluateCost(graph.network).cost, summary.final_cost, 1e-12 * summary.final_cost);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

TEST(Solve, StopsWhenTheCallbackSaysSo) {
  PoseGraph graph = MakePoseGraph(1);
  SolveOptions options;
  std::vector<IterationProgress> seen;
  options.on_iteration = [&](const IterationProgress& progress) {
    seen.push_back(progress);
    return progress.iteration < 1;
  };
  const SolveSummary summary = Solve(graph.network, options);
  EXPECT_TRUE(summary.interrupted);
  EXPECT_FALSE(summary.converged);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].iteration, 0);
  EXPECT_NEAR(seen[0].cost - seen[1].cost, seen[1].cost_change, 1e-9 * seen[0].cost);
  EXPECT_GT(seen[1].step_norm, 0.0);
  EXPECT_EQ(summary.final_cost, seen[1].cost);
}

// With Cauchy's loss each step is shorter than the previous one by a factor. The first step below
// the tolerance must end the solution.
TEST(Solve, EndsWhereAStepIsShortInSigmas) {
  const auto solve = [](double sigmas) {
    PoseGraph graph = MakePoseGraph(11, {.noise = 1.0});
    for (const FactorId id : graph.relative) graph.network.SetLoss(id, {Loss::Type::kCauchy, 2.0});
    std::vector<double> changes;
    SolveOptions options;
    options.initial_trust_region_radius = 1e13;
    options.second_attempt = false;
    options.function_tolerance = 1e-10;
    options.sigma_tolerance = sigmas;
    options.on_iteration = [&](const IterationProgress& progress) {
      changes.push_back(progress.cost_change);
      return true;
    };
    const SolveSummary summary = Solve(graph.network, options);
    EXPECT_TRUE(summary.converged) << summary.message;
    EXPECT_FALSE(summary.interrupted);
    EXPECT_EQ(summary.iterations + 1, static_cast<int>(changes.size()));
    return std::pair(summary, changes);
  };
  constexpr double kSigmas = 0.01, kLeast = 0.5 * kSigmas * kSigmas;
  const auto [whole, all] = solve(0.0);
  const auto [summary, changes] = solve(kSigmas);
  EXPECT_LT(summary.iterations, whole.iterations);
  EXPECT_NEAR(summary.final_cost, whole.final_cost, kLeast);
  for (std::size_t k = 1; k + 1 < changes.size(); ++k) EXPECT_GE(changes[k], kLeast);
  EXPECT_LT(changes.back(), kLeast);
}

TEST(Solve, NamesAnUndefinedFactorAndPrintsNothing) {
  Network net;
  const auto x = net.AddVector<1>("range offset", OneByOne(-1.0));
  net.Tag(net.Add(SquareRoot{}, x), "square root", 12.5);
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  const SolveSummary summary = Solve(net);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(summary.converged);
  EXPECT_NE(summary.message.find("factor 0 (square root, 12.500 s) on 'range offset'"),
            std::string::npos)
      << summary.message;
  EXPECT_EQ(net.Value(x)[0], -1.0);
  EXPECT_THROW(EvaluateCost(net), InvalidInput);
  EXPECT_THROW(EvaluateCost(net, 2), InvalidInput);
}

TEST(Solve, AnIterationLimitIsNotConvergence) {
  PoseGraph graph = MakePoseGraph(2);
  SolveOptions options;
  options.max_iterations = 1;
  const SolveSummary summary = Solve(graph.network, options);
  EXPECT_FALSE(summary.converged);
  EXPECT_FALSE(summary.interrupted);
  EXPECT_EQ(summary.iterations, 1);
}

TEST(Solve, NothingToSolveConverges) {
  Network empty;
  EXPECT_TRUE(Solve(empty).converged);
  Network held;
  const auto x = held.AddVector<1>("x", OneByOne(2.0));
  held.Add(Prior(1.0), x);
  held.Hold(x);
  const SolveSummary summary = Solve(held);
  EXPECT_TRUE(summary.converged);
  EXPECT_NEAR(summary.final_cost, 0.5, 1e-15);
  EXPECT_EQ(held.Value(x)[0], 2.0);
}

TEST(Solve, RejectsBadOptions) {
  Network net;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)Solve(net, {.max_iterations = -1}), InvalidConfig);
  EXPECT_THROW((void)Solve(net, {.threads = 0}), InvalidConfig);
  EXPECT_THROW((void)Solve(net, {.function_tolerance = -1e-9}), InvalidConfig);
  EXPECT_THROW((void)Solve(net, {.parameter_tolerance = nan}), InvalidConfig);
  EXPECT_THROW((void)Solve(net, {.gradient_tolerance = nan}), InvalidConfig);
  EXPECT_THROW((void)Solve(net, {.sigma_tolerance = nan}), InvalidConfig);
  EXPECT_THROW((void)Solve(net, {.initial_trust_region_radius = 0.0}), InvalidConfig);
}

}  // namespace dn::solvers_test
