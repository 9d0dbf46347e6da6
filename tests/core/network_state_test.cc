#include <dn/error.h>
#include <dn/linear_prior.h>
#include <dn/network_state.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

namespace dn::core_test {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A network with every parametrisation, and a prior of two blocks.
struct Example {
  Network net;
  Block<Rotation> q = net.AddRotation("attitude", Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5));
  Block<LeftRotation> left = net.AddLeftRotation("boresight", Eigen::Quaterniond::Identity());
  Block<Vec<3>> p = net.AddVector<3>("position", {1.0, 2.0, 3.0});
  Block<Pose> pose = net.AddPose("pose", {Eigen::Quaterniond::Identity(), {4.0, 5.0, 6.0}});
  FactorId prior = -1;

  Example() {
    Eigen::VectorXd center(7);
    center << net.Value(q).coeffs(), 1.0, 2.0, 2.5;
    prior = net.AddFactor(std::make_shared<LinearPrior>(
                              std::vector<BlockKind>{Rotation::kKind, Vec<3>::kKind}, center,
                              Eigen::MatrixXd::Identity(6, 6), Eigen::VectorXd::Ones(6), 0.25),
                          {q.id, p.id});
    net.Tag(prior, "yesterday", 0.0);
  }
};

TEST(NetworkState, CarriesValuesAndPriorsByName) {
  const Example from;
  const NetworkState state = GetState(from.net);
  ASSERT_EQ(state.blocks.size(), 4U);
  ASSERT_EQ(state.priors.size(), 1U);
  EXPECT_EQ(state.Find("position").value, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(state.Find("boresight").parametrisation, Parametrisation::kRotationLeft);
  EXPECT_THROW(state.Find("positron"), InvalidInput);
  Network to;  // in another order, with one block more
  const auto own = to.AddScalar("own", 7.0);
  const auto p = to.AddVector<3>("position", Eigen::Vector3d::Zero());
  const auto q = to.AddRotation("attitude", Eigen::Quaterniond::Identity());
  const auto pose = to.AddPose("pose", {});
  to.AddLeftRotation("boresight", Eigen::Quaterniond(0, 1, 0, 0));
  SetState(state, &to);
  EXPECT_EQ(to.Value(own), 7.0);
  EXPECT_EQ(to.Value(p), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(to.Value(q).coeffs(), from.net.Value(from.q).coeffs());
  EXPECT_EQ(to.Value(pose).p.y(), 5.0);
  ASSERT_EQ(to.num_factors(), 1);
  EXPECT_EQ(to.group(0).name, "yesterday");
  Eigen::VectorXd expected, r;
  ASSERT_TRUE(from.net.EvaluateFactor(from.prior, &expected));
  ASSERT_TRUE(to.EvaluateFactor(0, &r));
  EXPECT_EQ(r, expected);
  EXPECT_EQ(GetState(to).priors[0].nonlinearity, 0.25);
}

TEST(NetworkState, IsRefusedByANetworkWithoutItsBlocks) {
  const NetworkState state = GetState(Example().net);
  Example to;
  to.net.SetValue(to.p, Eigen::Vector3d::Zero());
  to.net.RemoveBlock(to.left);
  EXPECT_THAT([&] { SetState(state, &to.net); },
              ThrowsMessage<InvalidInput>(HasSubstr("no block 'boresight'")));
  to.net.AddRotation("boresight", Eigen::Quaterniond::Identity());
  EXPECT_THAT([&] { SetState(state, &to.net); },
              ThrowsMessage<InvalidInput>(HasSubstr("'boresight' has another kind")));
  EXPECT_EQ(to.net.Value(to.p), Eigen::Vector3d::Zero());
  EXPECT_EQ(to.net.num_factors(), 1);
}

TEST(NetworkState, GivesAPriorOfOneBlock) {
  Example to;
  NetworkState::Block block = GetState(to.net).Find("position");
  EXPECT_THROW(AddPrior(block, &to.net), InvalidInput);
  block.covariance = Eigen::Vector3d(0.25, 1.0, 4.0).asDiagonal();
  const FactorId id = AddPrior(block, &to.net);
  to.net.SetValue(to.p, {2.0, 3.0, 4.0});
  Eigen::VectorXd r;
  ASSERT_TRUE(to.net.EvaluateFactor(id, &r));
  EXPECT_LE((r - Eigen::Vector3d(2.0, 1.0, 0.5)).norm(), 1e-14);
  EXPECT_EQ(to.net.group(id).kind, FactorGroup::Kind::kPrior);
  block.covariance(0, 0) = -1.0;
  EXPECT_THROW(AddPrior(block, &to.net), InvalidInput);
}

}  // namespace dn::core_test
