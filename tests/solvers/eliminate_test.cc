#include <dn/error.h>
#include <dn/solvers/eliminate.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

// Rounding of two factorisations.
constexpr double kEliminationTolerance = 1e-8;

/// A chain of plane positions with noisy steps, seen from a station now and then.
struct Chain {
  Network net;
  std::vector<Block<Vec<2>>> x;
  std::mt19937 rng{5};
  std::normal_distribution<double> normal;

  Eigen::Vector2d Noisy() { return {normal(rng), normal(rng)}; }

  void AddNode() {
    const auto k = static_cast<double>(x.size());
    x.push_back(net.AddVector<2>("x/" + std::to_string(x.size()), Eigen::Vector2d::Zero()));
    if (x.size() > 1) {
      const Eigen::Vector2d step = Eigen::Vector2d(1.0, 0.5) + 0.1 * Noisy();
      net.Add([step](const auto& a, const auto& b) { return (b - a - step).eval(); },
              Noise<2>::Sigma(0.1), x[x.size() - 2], x.back());
    }
    if (x.size() % 7 != 1) return;
    const Eigen::Vector2d seen = k * Eigen::Vector2d(1.0, 0.5) + 0.3 * Noisy();
    net.Add([seen](const auto& a) { return (a - seen).eval(); }, Noise<2>::Sigma(0.3), x.back());
  }
  explicit Chain(int nodes) {
    for (int k = 0; k < nodes; ++k) AddNode();
  }
};

std::vector<BlockId> Ids(const std::vector<Block<Vec<2>>>& blocks, std::size_t first,
                         std::size_t past) {
  std::vector<BlockId> ids;
  for (std::size_t k = first; k < past; ++k) ids.push_back(blocks[k].id);
  return ids;
}

/// Expects the same values and covariances of the blocks that both networks have.
void ExpectSameResult(Network whole, Network rest, double tolerance = kEliminationTolerance) {
  ASSERT_TRUE(Solve(whole).converged);
  const SolveSummary summary = Solve(rest);
  ASSERT_TRUE(summary.converged);
  EXPECT_THAT(summary.warnings, IsEmpty());
  const Marginals expected(whole), got(rest);
  int compared = 0;
  for (BlockId b = 0; b < rest.num_blocks(); ++b) {
    if (rest.block(b).removed() || rest.block(b).held) continue;
    ++compared;
    Eigen::VectorXd difference(rest.block(b).kind.tangent_size);
    Minus(rest.block(b).kind, rest.Value(b).data(), whole.Value(b).data(), difference.data());
    const Eigen::MatrixXd C = expected.Covariance(b);
    EXPECT_LE(difference.norm(), tolerance * std::sqrt(C.trace())) << rest.block(b).name;
    EXPECT_LE((got.Covariance(b) - C).norm(), tolerance * C.norm()) << rest.block(b).name;
  }
  EXPECT_GT(compared, 0);
}

TEST(Eliminate, KeepsSolutionAndCovariancesOfALinearNetwork) {
  const std::pair<std::size_t, std::size_t> ranges[] = {
      {0, 1}, {0, 20}, {3, 9}, {10, 29}, {20, 30}};
  for (const auto& [first, past] : ranges) {
    SCOPED_TRACE(std::to_string(first) + " to " + std::to_string(past));
    Chain chain(30);
    Network rest = chain.net;
    const Elimination out = Eliminate(&rest, Ids(chain.x, first, past), {.threads = 2});
    EXPECT_EQ(out.neighbours.size(), (first > 0 ? 1U : 0U) + (past < 30 ? 1U : 0U));
    EXPECT_GT(out.factors, 0);
    ASSERT_GE(out.prior, 0);
    EXPECT_EQ(rest.group(out.prior).kind, FactorGroup::Kind::kPrior);
    EXPECT_EQ(rest.group(out.prior).name, "eliminated");
    EXPECT_THROW(rest.Value(chain.x[first]), InvalidInput);
    EXPECT_THROW(Marginals(rest).Covariance(chain.x[first].id), InvalidInput);
    ExpectSameResult(chain.net, rest);
  }
}

TEST(Eliminate, KeepsTheCost) {
  Chain chain(30);
  Network rest = chain.net;
  const Elimination out = Eliminate(&rest, Ids(chain.x, 4, 17));
  EXPECT_NEAR(Solve(chain.net).final_cost, Solve(rest).final_cost + out.cost, 1e-8);
}

// Steps alone determine only differences of the neighbours, so the prior has two rows.
TEST(Eliminate, MakesAPriorWithTheInformationThatThereIs) {
  Chain chain(14);
  Network rest = chain.net;
  const Elimination out = Eliminate(&rest, Ids(chain.x, 2, 6));
  EXPECT_EQ(out.neighbours.size(), 2U);
  EXPECT_EQ(rest.factor(out.prior).factor->residual_size(), 2);
  ExpectSameResult(chain.net, rest);
}

TEST(Eliminate, KeepsAPoseGraphAtItsSolution) {
  for (const unsigned seed : {2U, 3U}) {
    testing::PoseGraph graph = testing::MakePoseGraph(seed, {.noise = 1.0});
    ASSERT_TRUE(Solve(graph.network).converged);
    Network rest = graph.network;
    std::vector<BlockId> blocks;
    for (std::size_t k = 3; k < 12; ++k) {
      blocks.push_back(graph.q_mb[k].id);
      blocks.push_back(graph.p_mb[k].id);
    }
    const Elimination out = Eliminate(&rest, blocks);
    EXPECT_GT(out.neighbours.size(), 1U);
    ExpectSameResult(graph.network, rest, 1e-6);
    // Twice: the prior is among the factors that the second one replaces.
    Eliminate(&rest, {graph.q_mb[2].id, graph.p_mb[2].id, graph.q_mb[12].id, graph.p_mb[12].id});
    ExpectSameResult(graph.network, rest, 1e-6);
  }
}

TEST(Eliminate, KeepsTheWeightsOfRobustLosses) {
  Chain chain(30);
  for (FactorId id = 0; id < chain.net.num_factors(); ++id) {
    chain.net.SetLoss(id, Loss::Huber(0.5));
  }
  ASSERT_TRUE(Solve(chain.net).converged);
  Network rest = chain.net;
  Eliminate(&rest, Ids(chain.x, 0, 20));
  const Marginals expected(chain.net), got(rest);
  EXPECT_LE((expected.Covariance(chain.x[25]) - got.Covariance(chain.x[25])).norm(),
            1e-8 * expected.Covariance(chain.x[25]).norm());
  ASSERT_TRUE(Solve(rest).converged);
  EXPECT_LE((rest.Value(chain.x[25]) - chain.net.Value(chain.x[25])).norm(), 1e-6);
}

TEST(Eliminate, LeavesOutConstantNeighboursAndBlocks) {
  Chain chain(10);
  chain.net.Hold(chain.x[5]);
  chain.net.Hold(chain.x[2]);
  Network rest = chain.net;
  const Elimination out = Eliminate(&rest, Ids(chain.x, 1, 5));
  EXPECT_EQ(out.neighbours, std::vector<BlockId>{chain.x[0].id});
  ExpectSameResult(chain.net, rest);
  Chain alone(1);
  const Elimination nothing = Eliminate(&alone.net, {alone.x[0].id});
  EXPECT_EQ(nothing.prior, -1);
  EXPECT_EQ(alone.net.num_free_parameters(), 0);
}

TEST(Eliminate, RefusesWhatTheNeighboursDoNotDetermine) {
  Network net;
  const auto a = net.AddScalar("a", 1.0), b = net.AddScalar("b", 1.0), c = net.AddScalar("c", 1.0);
  net.Add([](const auto& x, const auto& y, const auto& z) { return x + y + z; },
          Noise<1>::Sigma(1.0), a, b, c);
  EXPECT_THAT([&] { Eliminate(&net, {a.id, b.id}); }, ThrowsMessage<RankDeficient>(HasSubstr("a")));
  EXPECT_EQ(net.num_free_parameters(), 3);
  EXPECT_TRUE(net.factor(0).active);
  Eliminate(&net, {a.id});
  EXPECT_THROW(Eliminate(&net, {a.id}), InvalidInput);
  // One residual determines the eliminated number and says nothing about the others.
  EXPECT_EQ(net.num_factors(), 1);
  EXPECT_FALSE(net.factor(0).active);
}

// A chain that keeps its last nodes gives the filter's result: the last node of the whole solution.
TEST(Eliminate, LetsAChainGrowAtConstantCost) {
  Chain whole(1), sliding(1);
  for (int k = 1; k < 300; ++k) {
    whole.AddNode();
    sliding.AddNode();
    if (sliding.x.size() > 3) {
      const Elimination out = Eliminate(&sliding.net, {sliding.x[sliding.x.size() - 4].id});
      EXPECT_LE(out.factors, 3);
    }
  }
  EXPECT_EQ(sliding.net.num_free_parameters(), 6);
  ExpectSameResult(whole.net, sliding.net);
}

/// A position seen by two distances from stations that are near; the prior of the second position
/// is not linear in it.
struct Ranges {
  Network net;
  Block<Vec<2>> a = net.AddVector<2>("a", {3.0, 4.0}), b = net.AddVector<2>("b", {4.0, 4.0});
  Ranges() {
    for (const double station : {-1.0, 0.0, 2.0}) {
      const Eigen::Vector2d s(station, 0.0);
      const double seen = (Eigen::Vector2d(3.0, 4.0) - s).norm();
      net.Add([=](const auto& p) { return (p - s).norm() - seen; }, Noise<1>::Sigma(0.5), a);
    }
    net.Add([](const auto& p, const auto& q) { return (q - p).norm() - 1.0; }, Noise<1>::Sigma(0.1),
            a, b);
    net.Add([](const auto& q) { return (q - Eigen::Vector2d(4.0, 4.0)).eval(); },
            Noise<2>::Sigma(1.0), b);
  }
};

TEST(Eliminate, WarnsIfTheNeighboursMoveTooFar) {
  Ranges ranges;
  ASSERT_TRUE(Solve(ranges.net).converged);
  const Elimination out = Eliminate(&ranges.net, {ranges.a.id});
  EXPECT_THAT(FindMovedPriors(ranges.net), IsEmpty());
  EXPECT_THAT(Solve(ranges.net).warnings, IsEmpty());
  ranges.net.Add([](const auto& q) { return (q - Eigen::Vector2d(7.0, 2.0)).eval(); },
                 Noise<2>::Sigma(0.01), ranges.b);
  const SolveSummary summary = Solve(ranges.net);
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_THAT(summary.warnings[0], HasSubstr("since the elimination"));
  const std::vector<MovedPrior> moved = FindMovedPriors(ranges.net);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].factor, out.prior);
  EXPECT_GT(moved[0].sigmas, 1.0);
  EXPECT_GT(moved[0].error, 0.1);
}

}  // namespace dn::solvers_test
