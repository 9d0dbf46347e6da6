#include <dn/network.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace dn::core_test {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// r = x - z over all numbers of one block of a size known at run time.
struct RunTimePrior final : DynamicAutoFactor<RunTimePrior> {
  Eigen::VectorXd z;
  explicit RunTimePrior(const Eigen::VectorXd& mean)
      : DynamicAutoFactor(static_cast<int>(mean.size()),
                          {VectorKind(static_cast<int>(mean.size()))}),
        z(mean) {}
  template <class T>
  bool Residual(const T* const* x, T* r) const {
    for (Eigen::Index i = 0; i < z.size(); ++i) r[i] = x[0][i] - z[i];
    return true;
  }
};

TEST(Network, TakesBlocksOfASizeKnownAtRunTime) {
  for (const int n : {1, 5, 17}) {
    Network net;
    const Eigen::VectorXd z = Eigen::VectorXd::LinSpaced(n, 1.0, 2.0);
    const BlockId b = net.AddBlock("coefficients", VectorKind(n), Eigen::VectorXd::Zero(n));
    EXPECT_EQ(net.block(b).kind.tangent_size, n);
    net.AddFactor(std::make_shared<RunTimePrior>(z), {b});
    Eigen::VectorXd r;
    ASSERT_TRUE(net.EvaluateFactor(0, &r));
    EXPECT_EQ(r, -z);
    net.SetValue(b, z);
    EXPECT_EQ(net.Value(b), z);
  }
}

TEST(Network, TakesEveryKindAtRunTime) {
  Network net;
  const BlockId q = net.AddBlock("q", Rotation::kKind, Eigen::Vector4d(0.0, 0.0, 3.0, 4.0));
  EXPECT_DOUBLE_EQ(net.Value(net.Find<Rotation>("q")).z(), 0.6);
  const BlockId pose = net.AddBlock("pose", MakeBlockKind<Pose>(),
                                    (Eigen::VectorXd(7) << 0, 0, 0, 1, 7, 8, 9).finished());
  EXPECT_EQ(net.Value(net.Find<Pose>("pose")).p.z(), 9.0);
  EXPECT_EQ(pose, q + 1);
}

TEST(Network, RejectsRunTimeBlocksWhoseSizesDoNotFit) {
  Network net;
  const Eigen::VectorXd three = Eigen::VectorXd::Zero(3);
  EXPECT_THAT([&] { net.AddBlock("x", VectorKind(4), three); },
              ThrowsMessage<InvalidInput>(HasSubstr("4 stored numbers")));
  EXPECT_THROW(net.AddBlock("x", VectorKind(0), Eigen::VectorXd()), InvalidInput);
  EXPECT_THROW(net.AddBlock("x", {Parametrisation::kVector, 3, 2}, three), InvalidInput);
  EXPECT_THROW(net.AddBlock("x", {Parametrisation::kManifold, 3, 3}, three), InvalidInput);
  EXPECT_THROW(net.AddBlock("x", {Parametrisation::kRotationLeft, 3, 3}, three), InvalidInput);
  const BlockId x = net.AddBlock("x", VectorKind(3), three);
  EXPECT_THROW(net.SetValue(x, Eigen::VectorXd::Zero(2)), InvalidInput);
}

FactorId AddDifference(Network* net, Block<Scalar> a, Block<Scalar> b, double z) {
  return net->Add([z](const auto& x, const auto& y) { return y - x - z; }, Noise<1>::Sigma(0.5), a,
                  b);
}

struct Chain {
  Network net;
  Block<Scalar> a = net.AddScalar("a", 1.0), b = net.AddScalar("b", 2.0),
                c = net.AddScalar("c", 4.0);
  FactorId ab = AddDifference(&net, a, b, 1.5), bc = AddDifference(&net, b, c, 2.5);
};

TEST(Network, RemovesABlockWithItsFactors) {
  Chain chain;
  chain.net.RemoveBlock(chain.a);
  EXPECT_EQ(chain.net.num_free_parameters(), 2);
  EXPECT_FALSE(chain.net.factor(chain.ab).active);
  EXPECT_TRUE(chain.net.factor(chain.bc).active);
  EXPECT_EQ(chain.net.Value(chain.c), 4.0);
  EXPECT_THAT([&] { chain.net.Value(chain.a); },
              ThrowsMessage<InvalidInput>(HasSubstr("was removed")));
  EXPECT_THAT([&] { chain.net.Hold(chain.a.id, false); },
              ThrowsMessage<InvalidInput>(HasSubstr("was removed")));
  EXPECT_THROW(AddDifference(&chain.net, chain.a, chain.b, 0.0), InvalidInput);
  EXPECT_THROW(chain.net.RemoveBlock(chain.a.id), InvalidInput);
  // The name is free, the id is not.
  const auto again = chain.net.AddScalar("a", 7.0);
  EXPECT_EQ(again.id, 3);
  const Network copy = chain.net;
  EXPECT_TRUE(copy.block(chain.a.id).removed());
  EXPECT_EQ(copy.Value(again), 7.0);
}

TEST(Network, AppendsAnotherWithASharedBlock) {
  Network both;
  Chain one, other;
  one.net.Tag(one.ab, "levelling", 3.0);
  one.net.SetLoss(one.bc, Loss::Huber(2.0));
  one.net.Hold(one.a);
  other.net.SetValue(other.c, 40.0);
  const Network::Appended first = both.Append(one.net, "1/", {"c"});
  const Network::Appended second = both.Append(other.net, "2/", {"c"});
  EXPECT_EQ(both.num_blocks(), 5);
  EXPECT_EQ(both.num_factors(), 4);
  EXPECT_EQ(first.Id(one.c.id), second.Id(other.c.id));
  EXPECT_EQ(both.Value(second.Handle(other.c)), 4.0);  // the value that was there first
  EXPECT_EQ(both.Value(second.Handle(other.b)), both.Value(both.Find<Scalar>("2/b")));
  EXPECT_TRUE(both.block(first.Id(one.a.id)).held);
  EXPECT_EQ(both.group(first.Factor(one.ab)).name, "levelling");
  EXPECT_EQ(both.factor(first.Factor(one.ab)).t_s, 3.0);
  EXPECT_EQ(both.factor(first.Factor(one.bc)).loss.width, 2.0);
  Eigen::VectorXd r;
  ASSERT_TRUE(both.EvaluateFactor(second.Factor(other.bc), &r));
  EXPECT_EQ(r[0], (4.0 - 2.0 - 2.5) / 0.5);
  EXPECT_THROW(second.Handle(one.b), InvalidInput);
}

TEST(Network, LeavesOutWhatWasRemovedWhenItIsAppended) {
  Chain chain;
  chain.net.RemoveBlock(chain.a);
  Network net;
  const Network::Appended appended = net.Append(chain.net, "");
  EXPECT_EQ(net.num_blocks(), 2);
  EXPECT_EQ(net.num_factors(), 1);
  EXPECT_THROW(appended.Id(chain.a.id), InvalidInput);
  EXPECT_THROW(appended.Factor(chain.ab), InvalidInput);
}

TEST(Network, AppendsACopyOfItself) {
  Chain chain;
  chain.net.Append(chain.net, "copy/");
  EXPECT_EQ(chain.net.num_blocks(), 6);
  EXPECT_EQ(chain.net.num_factors(), 4);
}

TEST(Network, RefusesToAppendWhatDoesNotFit) {
  Chain chain, other;
  EXPECT_THAT([&] { chain.net.Append(other.net, ""); },
              ThrowsMessage<InvalidInput>(HasSubstr("'a' of the appended network is taken")));
  EXPECT_THAT([&] { chain.net.Append(other.net, "2/", {"d"}); },
              ThrowsMessage<InvalidInput>(HasSubstr("no block 'd'")));
  Network vector;
  vector.AddVector<2>("a", {1.0, 2.0});
  EXPECT_THAT([&] { chain.net.Append(vector, "2/", {"a"}); },
              ThrowsMessage<InvalidInput>(HasSubstr("different kind")));
  EXPECT_EQ(chain.net.num_blocks(), 3);
  EXPECT_EQ(chain.net.num_factors(), 2);
}

}  // namespace dn::core_test
