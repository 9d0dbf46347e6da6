#include <dn/axis_names.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "solvers/pose_graph.h"
#include "solvers/step_factor.h"

namespace dn::solvers_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MakePoseGraph;
using testing::MakeVectorPrior;
using ::testing::Not;
using testing::PoseGraph;
using testing::Step;

/// r = (a + b - z) / sigma: observes only the sum.
struct ComponentSum : AutoFactor<ComponentSum, 1, Vec<3>, Vec<1>> {
  template <class T>
  bool Residual(const T* a, const T* b, T* r) const {
    r[0] = (a[1] + b[0] - T(1.0)) / 0.01;
    return true;
  }
};

/// r = k . x / sigma.
struct Combination : AutoFactor<Combination, 1, Vec<3>> {
  Eigen::Vector3d k;
  double sigma = 1.0;

  template <class T>
  bool Residual(const T* x, T* r) const {
    r[0] = (k[0] * x[0] + k[1] * x[1] + k[2] * x[2]) / sigma;
    return true;
  }
};

Combination See(const Eigen::Vector3d& k, double sigma = 1.0) {
  Combination f;
  f.k = k;
  f.sigma = sigma;
  return f;
}

std::string CatchMessage(const Network& network) {
  try {
    const Marginals marginals(network);
  } catch (const RankDeficient& error) {
    return error.what();
  }
  return "no exception";
}

BlockLabel Boresight() {
  return {"boresight", AxisNames(kRollPitchYaw), "deg", 57.3,
          std::numeric_limits<double>::quiet_NaN()};
}

// Only roll and the sum of pitch and yaw are observed, so their difference is undetermined.
TEST(Rank, NamesTheInseparableAngles) {
  Network net;
  const auto x = net.AddVector<3>("boresight", Eigen::Vector3d::Zero());
  net.SetLabel(x.id, Boresight());
  net.Add(See({1, 0, 0}), x);
  net.Add(See({0, 1, 1}, 1e-4), x);
  net.Add(See({0, 2, 2}, 1e-3), x);
  EXPECT_THAT(CatchMessage(net),
              AllOf(HasSubstr("leave 1 direction"), HasSubstr("boresight pitch (0.71)"),
                    HasSubstr("boresight yaw (0.71)"), Not(HasSubstr("roll")),
                    HasSubstr("give these unknowns a prior")));
}

TEST(Rank, NamesAComponentOnWhichNothingDepends) {
  Network net;
  const auto x = net.AddVector<3>("scale factors", Eigen::Vector3d::Zero());
  net.Add(See({1, 0, 0}), x);
  net.Add(See({1, 0, 1}), x);
  EXPECT_THAT(CatchMessage(net), HasSubstr("scale factors[1] (1.00)"));
}

// Names the gauge freedom of a free chain, by component and with its epochs.
TEST(Rank, NamesTheGaugeOfAChainOverTime) {
  Network net;
  std::vector<Block<Vec<3>>> x;
  for (int i = 0; i < 40; ++i) {
    x.push_back(net.AddVector<3>("position/" + std::to_string(i), Eigen::Vector3d::Zero()));
    net.SetLabel(x.back().id, {"position", AxisNames(kEnu), "m", 1.0, 381000.0 + 5.0 * i});
    if (i > 0) net.Add(Step{}, x[x.size() - 2], x.back());
  }
  net.Add(See({0, 0, 1}, 0.01), x[3]);
  EXPECT_THAT(CatchMessage(net), AllOf(HasSubstr("leave 2 directions"),
                                       HasSubstr("position east, 381000.0..381195.0 s (1.00)"),
                                       HasSubstr("position north, 381000.0..381195.0 s (1.00)"),
                                       Not(HasSubstr("position up"))));
}

// Names only the disconnected part of the flight.
TEST(Rank, NamesTheEpochsThatAreCutOff) {
  Network net;
  std::vector<Block<Vec<3>>> x;
  for (int i = 0; i < 40; ++i) {
    x.push_back(net.AddVector<3>("p/" + std::to_string(i), Eigen::Vector3d::Zero()));
    net.SetLabel(x.back().id, {"position", AxisNames(kEnu), "m", 1.0, 100.0 + i});
    if (i > 0 && i != 30) net.Add(Step{}, x[x.size() - 2], x.back());
  }
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 0.02), x[0]);
  EXPECT_THAT(CatchMessage(net), AllOf(HasSubstr("leave 3 directions"),
                                       HasSubstr("position up, 130.0..139.0 s (1.00)")));
}

TEST(Rank, AFreePoseGraphHasSixDirections) {
  PoseGraph graph = MakePoseGraph(3, {.nodes = 25, .anchored = false});
  EXPECT_THAT(CatchMessage(graph.network), HasSubstr("leave 6 directions"));
  graph.network.Hold(graph.p_mb[4]);
  EXPECT_THAT(CatchMessage(graph.network), HasSubstr("leave 3 directions"));
  graph.network.Hold(graph.q_mb[9]);
  EXPECT_EQ(CatchMessage(graph.network), "no exception");
}

TEST(Rank, NamesBlocksOfAUsersOwnKind) {
  Network net;
  const auto a = net.AddVector<3>("mount", Eigen::Vector3d::Zero());
  const auto b = net.AddVector<1>("range offset", Eigen::Matrix<double, 1, 1>(0.0));
  net.Add(See({1, 0, 0}), a);
  net.Add(See({0, 0, 1}), a);
  net.Add(ComponentSum{}, a, b);
  EXPECT_THAT(CatchMessage(net),
              AllOf(HasSubstr("mount[1] (0.71)"), HasSubstr("range offset (0.71)")));
}

TEST(Rank, MoreFreeDirectionsThanAreExamined) {
  Network net;
  for (int i = 0; i < 20; ++i) {
    const auto x = net.AddVector<3>("x/" + std::to_string(i), Eigen::Vector3d::Zero());
    net.Add(See({0, 1, 0}), x);
  }
  EXPECT_THAT(CatchMessage(net), AllOf(HasSubstr("at least 8 directions"), HasSubstr("...")));
}

// A direction with 1e-12 of the other information is weak but determined. A hand calculation gives
// its variance: the sum of y and z has sigma 1e-6 and their difference sigma 1.
TEST(Rank, AWeakDirectionIsNotFree) {
  Network net;
  const auto x = net.AddVector<3>("boresight", Eigen::Vector3d::Zero());
  net.Add(See({1, 0, 0}), x);
  net.Add(See({0, 1, 1}, 1e-6), x);
  net.Add(See({0, 1, -1}, 1.0), x);
  const Eigen::Matrix3d C = Marginals(net).Covariance(x);
  EXPECT_NEAR(C(1, 1), 0.25, 1e-3);  // a few times the rounding error 1e-16 / 1e-12
  EXPECT_NEAR(C(1, 2), -0.25, 1e-3);
}

TEST(Rank, AWeakGaugeOfALongChainIsNotFree) {
  Network net;
  std::vector<Block<Vec<3>>> x;
  for (int i = 0; i < 2000; ++i) {
    x.push_back(net.AddVector<3>("p/" + std::to_string(i), Eigen::Vector3d::Zero()));
    Step f;
    f.sigma = 1e-4;
    if (i > 0) net.Add(f, x[x.size() - 2], x.back());
  }
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 1.0), x[1000]);
  const Eigen::Matrix3d C = Marginals(net).Covariance(x[0]);
  EXPECT_NEAR(C(0, 0), 1.0 + 1000 * 1e-8, 1e-4);
}

}  // namespace dn::solvers_test
