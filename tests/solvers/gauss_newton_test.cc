#include <dn/error.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/shared_analysis.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using testing::MakePoseGraph;
using testing::PoseGraph;

// With this number of blocks Solve starts with undamped steps.
constexpr int kManyBlocks = 100;

/// r = 10 atan(x - z): undamped steps diverge if |x - z| > 1.4.
struct Arctangent : AutoFactor<Arctangent, 1, Vec<1>> {
  double z = 0.0;

  template <class T>
  bool Residual(const T* x, T* r) const {
    using std::atan;
    r[0] = 10.0 * atan(x[0] - z);
    return true;
  }
};

/// r = sqrt(x) - 1: undefined below zero, where it throws if `throws` is set.
struct Root : AutoFactor<Root, 1, Vec<1>> {
  bool throws = false;

  template <class T>
  bool Residual(const T* x, T* r) const {
    using std::sqrt;
    if (x[0] < T(0.0)) {
      if (throws) throw InvalidInput("root of a negative number");
      return false;
    }
    r[0] = sqrt(x[0]) - T(1.0);
    return true;
  }
};

struct Row {
  Network net;
  std::vector<Block<Vec<1>>> x;
};

/// Creates blocks with the same initial value, each with its own factor.
template <class Factor>
Row MakeRow(const Factor& factor, double start) {
  Row row;
  for (int i = 0; i < kManyBlocks; ++i) {
    row.x.push_back(
        row.net.AddVector<1>("x" + std::to_string(i), Eigen::Matrix<double, 1, 1>(start)));
    row.net.Add(factor, row.x.back());
  }
  return row;
}

double LargestError(const Row& row, double truth) {
  double largest = 0.0;
  for (const auto& x : row.x) largest = std::max(largest, std::abs(row.net.Value(x)[0] - truth));
  return largest;
}

TEST(GaussNewton, EndsWhereDampedStepsEnd) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    PoseGraph undamped = MakePoseGraph(seed, {.nodes = 90, .loops = 60, .noise = 1.0});
    PoseGraph damped = MakePoseGraph(seed, {.nodes = 90, .loops = 60, .noise = 1.0});
    for (PoseGraph* graph : {&undamped, &damped}) {
      for (std::size_t k = 0; k < graph->relative.size(); k += 7) {
        graph->network.SetLoss(graph->relative[k], Loss::Huber(1.0));
      }
    }
    const SolveSummary a = Solve(undamped.network, {.threads = 2});
    const SolveSummary b = Solve(damped.network, {.start_undamped = false});
    ASSERT_TRUE(a.converged && b.converged) << a.message << "; " << b.message;
    EXPECT_NEAR(a.initial_cost, b.initial_cost, 1e-9 * b.initial_cost);
    EXPECT_NEAR(a.final_cost, b.final_cost, 1e-9 * b.final_cost);
    const Marginals marginals(damped.network);
    for (std::size_t i = 0; i < damped.p_mb.size(); ++i) {
      const Eigen::Vector3d d =
          undamped.network.Value(undamped.p_mb[i]) - damped.network.Value(damped.p_mb[i]);
      const Eigen::Vector3d sigma = marginals.Sigma(damped.p_mb[i]);
      EXPECT_LT(d.cwiseQuotient(sigma).norm(), 1e-5) << i;
    }
  }
}

TEST(GaussNewton, DampedStepsGoOnWhereAnUndampedOneLeadsAstray) {
  Arctangent f;
  f.z = 3.0;
  Row row = MakeRow(f, 0.0);
  std::vector<int> iterations;
  const SolveSummary summary =
      Solve(row.net, {.on_iteration = [&](const IterationProgress& progress) {
              iterations.push_back(progress.iteration);
              return true;
            }});
  ASSERT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(LargestError(row, 3.0), 1e-7);
  ASSERT_EQ(static_cast<int>(iterations.size()), summary.iterations + 1);
  for (std::size_t k = 0; k < iterations.size(); ++k) {
    EXPECT_EQ(iterations[k], static_cast<int>(k));
  }
  const double atan3 = 10.0 * std::atan(3.0);
  EXPECT_NEAR(summary.initial_cost, 0.5 * kManyBlocks * atan3 * atan3, 1e-9);
}

TEST(GaussNewton, DampedStepsGoOnWhereAFactorIsUndefined) {
  Row row = MakeRow(Root{}, 9.0);
  const SolveSummary summary = Solve(row.net);
  ASSERT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(LargestError(row, 1.0), 1e-7);
}

TEST(GaussNewton, AnExceptionLeavesTheLastGoodValues) {
  Root f;
  f.throws = true;
  Row row = MakeRow(f, 9.0);
  EXPECT_THROW((void)Solve(row.net), InvalidInput);
  EXPECT_EQ(LargestError(row, 9.0), 0.0);
}

TEST(GaussNewton, StopsOnRequest) {
  PoseGraph graph = MakePoseGraph(3, {.nodes = 90});
  const SolveSummary summary = Solve(
      graph.network, {.on_iteration = [](const IterationProgress& p) { return p.iteration < 2; }});
  EXPECT_TRUE(summary.interrupted);
  EXPECT_FALSE(summary.converged);
  EXPECT_EQ(summary.iterations, 2);
  EXPECT_NEAR(EvaluateCost(graph.network).cost, summary.final_cost, 1e-9 * summary.final_cost);
}

TEST(GaussNewton, ANetworkWithoutDatumStillConverges) {
  PoseGraph graph = MakePoseGraph(4, {.nodes = 90, .noise = 1.0, .anchored = false});
  const SolveSummary summary = Solve(graph.network);
  EXPECT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(summary.final_cost, 1e3);
}

TEST(SharedAnalysis, ServesTheCovariancesOfWhatWasSolved) {
  PoseGraph graph = MakePoseGraph(5, {.nodes = 90, .noise = 1.0});
  const auto analysis = std::make_shared<SharedAnalysis>();
  ASSERT_TRUE(Solve(graph.network, {.analysis = analysis}).converged);
  const Marginals shared(graph.network, {.analysis = analysis});
  const Marginals own(graph.network);
  EXPECT_EQ(shared.timings().analyze_s, 0.0);
  EXPECT_GT(own.timings().analyze_s, 0.0);
  for (const auto& p : graph.p_mb) EXPECT_EQ(shared.Covariance(p), own.Covariance(p));
}

// An analysis can be reused if the new network has fewer connections between blocks; more
// connections require a new analysis.
TEST(SharedAnalysis, FollowsAStructureThatChanges) {
  const auto analysis = std::make_shared<SharedAnalysis>();
  PoseGraph graph = MakePoseGraph(6, {.nodes = 90, .loops = 40});
  ASSERT_TRUE(Solve(graph.network, {.analysis = analysis}).converged);
  graph.network.SetActive(graph.relative.back(), false);
  const Marginals fewer(graph.network, {.analysis = analysis});
  EXPECT_EQ(fewer.timings().analyze_s, 0.0);
  EXPECT_TRUE(
      fewer.Covariance(graph.q_bs).isApprox(Marginals(graph.network).Covariance(graph.q_bs), 1e-9));
  const auto far = graph.network.AddVector<1>("far", Eigen::Matrix<double, 1, 1>(0.0));
  graph.network.Add(testing::MakeVectorPrior<1>(Eigen::Matrix<double, 1, 1>(1.0), 2.0), far);
  const Marginals more(graph.network, {.analysis = analysis});
  EXPECT_GT(more.timings().analyze_s, 0.0);
  EXPECT_NEAR(more.Covariance(far)(0, 0), 4.0, 1e-12);
}

}  // namespace dn::solvers_test
