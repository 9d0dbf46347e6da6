#include <dn/solvers/propagate.h>
#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "solvers/pose_graph.h"
#include "solvers/step_factor.h"

namespace dn::solvers_test {

using testing::MakePoseGraph;
using testing::MakeVectorPrior;
using testing::PoseGraph;
using testing::Step;

// Two positions are 3 and 4 m apart along x and y, with sigmas of 0.1 and 0.2 m. The distance has
// the sigma sqrt(0.01 + 0.04), from the components along the line between them.
TEST(Propagate, DistanceOfTwoPositions) {
  Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d(1.0, 2.0, 5.0));
  const auto q = net.AddVector<3>("q", Eigen::Vector3d(4.0, 6.0, 5.0));
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d(1.0, 2.0, 5.0), 0.1), p);
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d(4.0, 6.0, 5.0), 0.2), q);
  const Marginals marginals(net);
  net.SetValue(p, Eigen::Vector3d::Zero());  // must not affect the marginals
  const auto distance = Propagate(
      marginals, [](const auto& a, const auto& b) { return (a - b).norm(); }, p, q);
  EXPECT_NEAR(distance.value[0], 5.0, 1e-14);
  EXPECT_NEAR(distance.covariance(0, 0), 0.05, 1e-14);
  EXPECT_NEAR(distance.sigma()[0], std::sqrt(0.05), 1e-14);
}

// b = a + 0.1: both have the error of the prior of a, but their difference does not.
TEST(Propagate, CountsWhatUnknownsHaveInCommon) {
  Network net;
  const auto a = net.AddVector<3>("a", Eigen::Vector3d::Zero());
  const auto b = net.AddVector<3>("b", Eigen::Vector3d::Zero());
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 10.0), a);
  Step step;
  step.sigma = 0.1;
  net.Add(step, a, b);
  const Marginals marginals(net);
  const Eigen::Matrix<double, 6, 6> joint = Joint(marginals, a, b);
  EXPECT_NEAR(joint(0, 0), 100.0, 1e-9);
  EXPECT_NEAR(joint(3, 3), 100.01, 1e-9);
  EXPECT_NEAR(joint(0, 3), 100.0, 1e-9);
  const auto difference = Propagate(
      marginals, [](const auto& x, const auto& y) { return (y - x).eval(); }, a, b);
  EXPECT_LT((difference.covariance - 0.01 * Eigen::Matrix3d::Identity()).norm(), 1e-9);
}

// A lever arm rotated by an attitude: J = [-R [a]x, R] in tangent coordinates, by hand.
TEST(Propagate, ThroughTheTangentOfARotation) {
  const PoseGraph graph = MakePoseGraph(7, {.noise = 1.0});
  const Marginals marginals(graph.network);
  const Block<Rotation> q_mb = graph.q_mb[4];
  const Block<Vec<3>> p_mb = graph.p_mb[4];
  const Eigen::Vector3d a_b(1.0, -2.0, 0.5);
  const auto point = Propagate(
      marginals,
      [&](const auto& q, const auto& p) {
        using T = std::decay_t<decltype(p.x())>;
        return Eigen::Matrix<T, 3, 1>(p + q * a_b.cast<T>());
      },
      q_mb, p_mb);
  const Eigen::Matrix3d R = graph.network.Value(q_mb).toRotationMatrix();
  Eigen::Matrix<double, 3, 6> J;
  J << -R * Skew(a_b), Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d expected = J * Joint(marginals, q_mb, p_mb) * J.transpose();
  EXPECT_LT((point.value - graph.network.Value(p_mb) - R * a_b).norm(), 1e-12);
  EXPECT_LT((point.covariance - expected).norm(), 1e-12 * expected.norm());
}

// Functions receive numbers and poses as in Network::Add. The sigma of x^2 is 2 x sigma. A point of
// a pose has the covariance of the translation plus that of the rotated lever arm.
TEST(Propagate, TakesNumbersAndPoses) {
  Network net;
  const auto x = net.AddScalar("x", 3.0);
  net.Add([](const auto& value) { return value - 3.0; }, Noise<1>::Sigma(0.1), x);
  const auto T_mb = net.AddPose("T_mb", {Eigen::Quaterniond::Identity(), {1.0, 2.0, 3.0}});
  net.Add([](const auto& pose) { return pose.ToVector(); },
          Noise<6>::Sigma((Eigen::Matrix<double, 6, 1>() << 0.01, 0.01, 0.02, 1, 1, 1).finished()),
          T_mb);
  net.SetValue(T_mb, {Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()});
  const Marginals marginals(net);
  const auto square = Propagate(
      marginals, [](const auto& value) { return value * value; }, x);
  EXPECT_NEAR(square.value[0], 9.0, 1e-12);
  EXPECT_NEAR(square.sigma()[0], 0.6, 1e-12);
  const auto point = Propagate(
      marginals,
      [](const auto& pose) {
        using T = std::decay_t<decltype(pose.p.x())>;
        return Eigen::Matrix<T, 3, 1>(pose.p + pose.q * Eigen::Matrix<T, 3, 1>(T(100), T(0), T(0)));
      },
      T_mb);
  EXPECT_LT((point.sigma() - Eigen::Vector3d(1.0, std::sqrt(5.0), std::sqrt(2.0))).norm(), 1e-12);
}

TEST(Joint, HoldsTheCovarianceOfEachBlockAndZeroForOneThatIsHeld) {
  PoseGraph graph = MakePoseGraph(2, {.noise = 1.0});
  graph.network.Hold(graph.q_bs);
  const Marginals marginals(graph.network);
  const auto joint = Joint(marginals, graph.p_mb[3], graph.q_bs, graph.p_mb[20]);
  EXPECT_LT((joint.topLeftCorner<3, 3>() - marginals.Covariance(graph.p_mb[3])).norm(), 1e-12);
  EXPECT_LT(
      (joint.topRightCorner<3, 3>() - marginals.Covariance(graph.p_mb[3], graph.p_mb[20])).norm(),
      1e-12);
  EXPECT_EQ((joint.block<3, 9>(3, 0).norm()), 0.0);
}

}  // namespace dn::solvers_test
