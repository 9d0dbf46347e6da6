#include <dn/error.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/restricted_likelihood.h>
#include <dn/solvers/score_test.h>
#include <dn/solvers/solve.h>
#include <dn/solvers/weak_directions.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using testing::MakePoseGraph;
using testing::PoseGraph;
using testing::PoseGraphOptions;

/// Both factorise in double precision; the condition numbers of these networks are below 1e6.
constexpr double kSame = 1e-9;

struct Graph {
  unsigned seed;
  PoseGraphOptions options;
};

/// A chain, a graph with some loops and one that is almost full.
const std::vector<Graph>& Graphs() {
  static const std::vector<Graph> graphs = {{1, {.nodes = 120, .loops = 0, .noise = 1.0}},
                                            {2, {.nodes = 90, .loops = 60, .noise = 1.0}},
                                            {3, {.nodes = 60, .loops = 900, .noise = 1.0}}};
  return graphs;
}

PoseGraph Solved(const Graph& graph, LinearAlgebra linear_algebra) {
  PoseGraph solved = MakePoseGraph(graph.seed, graph.options);
  SolveOptions options;
  options.linear_algebra = linear_algebra;
  EXPECT_TRUE(Solve(solved.network, options).converged);
  return solved;
}

Marginals Factored(const Network& network, LinearAlgebra linear_algebra) {
  return Marginals(network, {.linear_algebra = linear_algebra});
}

void ExpectSame(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  EXPECT_LE((a - b).norm(), kSame * b.norm());
}

TEST(LinearAlgebra, SolutionsAreEqual) {
  for (const Graph& graph : Graphs()) {
    SCOPED_TRACE(graph.seed);
    const PoseGraph own = Solved(graph, LinearAlgebra::kMultifrontal);
    const PoseGraph cholmod = Solved(graph, LinearAlgebra::kCholmod);
    for (std::size_t i = 0; i < own.p_mb.size(); ++i) {
      ExpectSame(own.network.Value(own.p_mb[i]), cholmod.network.Value(cholmod.p_mb[i]));
      ExpectSame(own.network.Value(own.q_mb[i]).coeffs(),
                 cholmod.network.Value(cholmod.q_mb[i]).coeffs());
    }
  }
}

TEST(LinearAlgebra, CovariancesAreEqual) {
  for (const Graph& graph : Graphs()) {
    SCOPED_TRACE(graph.seed);
    const PoseGraph solved = Solved(graph, LinearAlgebra::kMultifrontal);
    Marginals own = Factored(solved.network, LinearAlgebra::kMultifrontal);
    Marginals cholmod = Factored(solved.network, LinearAlgebra::kCholmod);
    const std::vector<BlockId> chosen = {solved.q_bs.id, solved.p_mb[7].id};
    for (const auto& p : solved.p_mb) {
      ExpectSame(own.SolveColumns(chosen).Rows(p.id), cholmod.SolveColumns(chosen).Rows(p.id));
    }
    own.ComputeSelectedInverse();
    cholmod.ComputeSelectedInverse();
    for (std::size_t i = 0; i < solved.p_mb.size(); ++i) {
      const std::vector<BlockId> pose = {solved.q_mb[i].id, solved.p_mb[i].id};
      ExpectSame(*own.JointSelectedCovariance(pose), *cholmod.JointSelectedCovariance(pose));
    }
    EXPECT_NEAR(own.LogDeterminant(), cholmod.LogDeterminant(), kSame * own.LogDeterminant());
    EXPECT_EQ(own.factor_nonzeros(), cholmod.factor_nonzeros());
  }
}

TEST(LinearAlgebra, ResidualsAndTestsOfEffectsAreEqual) {
  for (const Graph& graph : Graphs()) {
    SCOPED_TRACE(graph.seed);
    const PoseGraph solved = Solved(graph, LinearAlgebra::kMultifrontal);
    const Marginals own = Factored(solved.network, LinearAlgebra::kMultifrontal);
    const Marginals cholmod = Factored(solved.network, LinearAlgebra::kCholmod);
    const Eigen::MatrixXd E = Eigen::MatrixXd::Random(own.linearized().rows(), 37);
    ExpectSame(own.Project(E), cholmod.Project(E));

    std::vector<EffectModel> effects;
    for (std::size_t k = 0; k < 40; ++k) {
      effects.push_back({{solved.relative[k], Eigen::MatrixXd::Random(6, 2)}});
    }
    const JointScore by_own = ScoreEffects(own, effects, {solved.q_bs.id});
    const JointScore by_cholmod = ScoreEffects(cholmod, effects, {solved.q_bs.id});
    ExpectSame(by_own.A, by_cholmod.A);
    ExpectSame(by_own.shift, by_cholmod.shift);
  }
}

std::string Failure(const Network& network, LinearAlgebra linear_algebra) {
  try {
    (void)Factored(network, linear_algebra);
  } catch (const RankDeficient& error) {
    return error.what();
  }
  return "";
}

TEST(LinearAlgebra, FreeDirectionsAreEqual) {
  for (Graph graph : Graphs()) {
    graph.options.anchored = false;
    const PoseGraph free = MakePoseGraph(graph.seed, graph.options);
    const std::string own = Failure(free.network, LinearAlgebra::kMultifrontal);
    EXPECT_NE(own.find("6 directions"), std::string::npos) << own;
    EXPECT_NE(Failure(free.network, LinearAlgebra::kCholmod).find("6 directions"),
              std::string::npos);
  }
}

TEST(LinearAlgebra, WeakDirectionsAreEqual) {
  const PoseGraph solved = Solved(Graphs()[1], LinearAlgebra::kMultifrontal);
  const auto own = WeakDirections(Factored(solved.network, LinearAlgebra::kMultifrontal), 2);
  const auto cholmod = WeakDirections(Factored(solved.network, LinearAlgebra::kCholmod), 2);
  for (std::size_t k = 0; k < own.size(); ++k) {
    EXPECT_NEAR(own[k].information, cholmod[k].information, kSame * own[k].information);
  }
}

TEST(LinearAlgebra, ASharedAnalysisFollowsTheChoice) {
  const PoseGraph solved = Solved(Graphs()[1], LinearAlgebra::kMultifrontal);
  const auto shared = std::make_shared<SharedAnalysis>();
  const Eigen::MatrixXd expected = Marginals(solved.network).Covariance(solved.q_bs.id);
  for (const LinearAlgebra choice : {LinearAlgebra::kMultifrontal, LinearAlgebra::kCholmod,
                                     LinearAlgebra::kCholmod, LinearAlgebra::kMultifrontal}) {
    const Marginals marginals(solved.network, {.linear_algebra = choice, .analysis = shared});
    ExpectSame(marginals.Covariance(solved.q_bs.id), expected);
  }
}

}  // namespace dn::solvers_test
