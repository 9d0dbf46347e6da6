#include <dn/solvers/solve.h>
#include <dn/solvers/state_covariance.h>
#include <gtest/gtest.h>

#include <string>

#include "solvers/pose_graph.h"

namespace dn::solvers_test {

TEST(StateCovariance, IsThatOfTheMarginals) {
  testing::PoseGraph graph = testing::MakePoseGraph(3, {.noise = 1.0});
  graph.network.AddScalar("unused", 1.0);
  graph.network.Hold(graph.p_mb[2]);
  Marginals marginals(graph.network);
  const Marginals reference(graph.network);
  NetworkState state = GetState(graph.network);
  AddCovariances(&marginals, graph.network, &state);
  const Eigen::MatrixXd expected = reference.Covariance(graph.q_mb[5]);
  const NetworkState::Block& block = state.Find(graph.network.block(graph.q_mb[5].id).name);
  EXPECT_LE((block.covariance - expected).norm(), 1e-9 * expected.norm());
  EXPECT_EQ(state.Find(graph.network.block(graph.p_mb[2].id).name).covariance,
            Eigen::MatrixXd::Zero(3, 3));
  EXPECT_EQ(state.Find("unused").covariance.size(), 0);
}

// The estimate of one day as the prior of the next equals one adjustment of both days.
TEST(StateCovariance, MakesThePriorOfTheNextDay) {
  const auto add = [](Network* net, Block<Vec<2>> x, double from, double to) {
    for (double z = from; z < to; z += 1.0) {
      net->Add([z](const auto& v) { return v[0] + z * v[1] - 2.0 * z - 1.0 / (1.0 + z * z); },
               Noise<1>::Sigma(0.1), x);
    }
  };
  Network both, monday, tuesday;
  const auto x = both.AddVector<2>("line", {0.0, 0.0});
  add(&both, x, 0.0, 10.0);
  const auto first = monday.AddVector<2>("line", {0.0, 0.0});
  add(&monday, first, 0.0, 5.0);
  const auto second = tuesday.AddVector<2>("line", {0.0, 0.0});
  add(&tuesday, second, 5.0, 10.0);
  EXPECT_TRUE(Solve(both).converged);
  EXPECT_TRUE(Solve(monday).converged);
  Marginals marginals(monday);
  NetworkState state = GetState(monday);
  AddCovariances(&marginals, monday, &state);
  AddPrior(state.Find("line"), &tuesday);
  EXPECT_TRUE(Solve(tuesday).converged);
  EXPECT_LE((tuesday.Value(second) - both.Value(x)).norm(), 1e-9);
  EXPECT_LE((MarginalSigma(tuesday, second) - MarginalSigma(both, x)).norm(), 1e-9);
}

}  // namespace dn::solvers_test
