#include <dn/network.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <type_traits>
#include <utility>

namespace dn::core_test {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const double kNan = std::numeric_limits<double>::quiet_NaN();

/// r = a_x - b.
struct Gap : AutoFactor<Gap, 1, Vec<3>, Vec<1>> {
  template <class T>
  bool Residual(const T* a, const T* b, T* r) const {
    r[0] = a[0] - b[0];
    return true;
  }
};

/// r = a - b for blocks known at run time.
class RunTimeGap final : public DynamicFactor {
 public:
  explicit RunTimeGap(std::vector<BlockKind> kinds, int residuals = 1)
      : DynamicFactor(residuals, std::move(kinds)) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    r[0] = x[0][0] - x[1][0];
    Put(0, x, J, Eigen::Matrix<double, 1, 1>(1.0));
    Put(1, x, J, Eigen::Matrix<double, 1, 1>(-1.0));
    return true;
  }
};

Eigen::Matrix<double, 1, 1> Scalar(double x) { return Eigen::Matrix<double, 1, 1>(x); }

TEST(Network, KeepsValuesByHandle) {
  Network net;
  const auto q = net.AddRotation("q", Eigen::Quaterniond(0.0, 0.0, 0.0, -4.0));
  const auto p = net.AddVector<3>("p", {1.0, 2.0, 3.0});
  EXPECT_EQ(net.Value(q).z(), -1.0);  // normalised
  EXPECT_EQ(net.Value(p), Eigen::Vector3d(1.0, 2.0, 3.0));
  net.SetValue(p, {4.0, 5.0, 6.0});
  net.SetValue(q, Eigen::Quaterniond(2.0, 0.0, 0.0, 0.0));
  EXPECT_EQ(net.Value(p).y(), 5.0);
  EXPECT_EQ(net.Value(q).w(), 1.0);
  EXPECT_EQ(net.num_blocks(), 2);
  EXPECT_EQ(net.num_free_parameters(), 6);
  net.Hold(q);
  EXPECT_EQ(net.num_free_parameters(), 3);
  net.Hold(q, false);
  EXPECT_EQ(net.num_free_parameters(), 6);
}

TEST(Network, AddressesOfValuesAreStable) {
  Network net;
  const auto first = net.AddVector<3>("first", Eigen::Vector3d::Zero());
  const double* address = net.block(first.id).value.get();
  for (int i = 0; i < 1000; ++i) net.AddVector<3>(std::to_string(i), Eigen::Vector3d::Zero());
  const Network moved = std::move(net);
  EXPECT_EQ(moved.block(first.id).value.get(), address);
}

static_assert(std::is_nothrow_move_constructible_v<Network>);
static_assert(std::is_nothrow_move_assignable_v<Network>);

TEST(Network, IsEmptyAndUsableAfterAMove) {
  Network net;
  net.AddScalar("a", 1.0);
  const Network moved = std::move(net);
  EXPECT_EQ(moved.num_blocks(), 1);
  net = Network(std::move(net));
  EXPECT_EQ(net.num_blocks(), 0);
  const auto a = net.AddScalar("a", 2.0);
  const FactorId f = net.Add([](const auto& x) { return x - 1.0; }, Noise<1>::Sigma(1.0), a);
  EXPECT_EQ(net.group(f).name, "");
}

// A constant network gives read access only.
template <class N>
using StoredNumber = decltype(std::declval<N&>().block(0).value[0]);
template <class N>
using StoredNumbers = decltype(std::declval<N&>().block(0).value.get());
static_assert(std::is_same_v<StoredNumber<const Network>, double>);
static_assert(std::is_same_v<StoredNumbers<const Network>, const double*>);
static_assert(std::is_same_v<StoredNumber<Network>, double&>);

// A fixed size that differs does not compile: see compile_errors/vector_size.cc.
TEST(Network, RejectsDynamicValuesOfAnotherSize) {
  Network net;
  const Eigen::VectorXd two = Eigen::VectorXd::Ones(2), three = Eigen::VectorXd::Ones(3);
  EXPECT_THAT(
      [&] { net.AddVector<3>("p", two); },
      ThrowsMessage<InvalidInput>(HasSubstr("value of block 'p' has size 2 x 1, must be 3 x 1")));
  const auto p = net.AddVector<3>("p", 2.0 * three);
  EXPECT_EQ(net.Value(p), Eigen::Vector3d(2, 2, 2));
  net.SetValue(p, three.transpose());
  EXPECT_EQ(net.Value(p), Eigen::Vector3d(1, 1, 1));
  EXPECT_THAT([&] { net.SetValue(p, two); },
              ThrowsMessage<InvalidInput>(HasSubstr("value of block 'p' has size 2 x 1")));
  EXPECT_EQ(net.Value(p), Eigen::Vector3d(1, 1, 1));
}

TEST(Network, RejectsBadBlocks) {
  Network net;
  net.AddVector<1>("x", Scalar(0.0));
  EXPECT_THAT([&] { net.AddVector<1>("x", Scalar(0.0)); },
              ThrowsMessage<InvalidInput>(HasSubstr("'x' is taken")));
  EXPECT_THAT([&] { net.AddVector<1>("y", Scalar(kNan)); },
              ThrowsMessage<InvalidInput>(HasSubstr("'y' is not finite")));
  EXPECT_THAT([&] { net.AddRotation("q", Eigen::Quaterniond(0, 0, 0, 0)); },
              ThrowsMessage<InvalidInput>(HasSubstr("'q' has zero norm")));
  EXPECT_EQ(net.num_blocks(), 1);
  // The failed AddRotation did not take the name.
  EXPECT_EQ(net.AddVector<1>("y", Scalar(1.0)).id, 1);
  EXPECT_THROW(net.SetValue(Block<Vec<1>>{1}, Scalar(kNan)), InvalidInput);
  EXPECT_EQ(net.Value(Block<Vec<1>>{1})[0], 1.0);
}

TEST(Network, RejectsHandlesOfAnotherNetwork) {
  Network one, other;
  one.AddVector<1>("x", Scalar(0.0));
  const auto p = other.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto q = other.AddRotation("q", Eigen::Quaterniond::Identity());
  EXPECT_THAT([&] { one.Value(p); }, ThrowsMessage<InvalidInput>(HasSubstr("another network")));
  EXPECT_THROW(one.SetValue(p, Eigen::Vector3d::Zero()), InvalidInput);
  EXPECT_THROW(one.Value(q), InvalidInput);
  EXPECT_THROW(one.Hold(Block<Rotation>{}), InvalidInput);
}

// The kinds and ids agree, so that only the identity of the network shows the mistake.
TEST(Network, RejectsHandlesOfAnotherNetworkOfTheSameShape) {
  Network one, other;
  const auto a = one.AddScalar("a", 1.0);
  const auto b = other.AddScalar("b", 2.0);
  const auto names_the_mistake =
      ThrowsMessage<InvalidInput>(HasSubstr("handle of a block of another network"));
  EXPECT_THAT([&] { one.Value(b); }, names_the_mistake);
  EXPECT_THAT([&] { one.SetValue(b, 3.0); }, names_the_mistake);
  EXPECT_THAT([&] { one.Hold(b); }, names_the_mistake);
  EXPECT_THAT([&] { one.Add([](const auto& x) { return x; }, Noise<1>::Sigma(1.0), b); },
              names_the_mistake);
  EXPECT_EQ(one.num_factors(), 0);
  EXPECT_EQ(one.Value(a), 1.0);
}

TEST(Network, TakesHandlesOfItsOriginal) {
  Network net;
  const auto a = net.AddScalar("a", 1.0);
  Network copy = net;
  EXPECT_EQ(copy.Value(a), 1.0);
  const auto of_copy = copy.AddScalar("b", 2.0);
  const auto of_net = net.AddScalar("c", 3.0);
  EXPECT_THROW(net.Value(of_copy), InvalidInput);
  EXPECT_THROW(copy.Value(of_net), InvalidInput);
  const Network moved = std::move(net);
  EXPECT_EQ(moved.Value(a), 1.0);
  EXPECT_EQ(moved.Value(of_net), 3.0);
  net = Network();
  const auto reused = net.AddScalar("a", 4.0);
  EXPECT_THROW(moved.Value(reused), InvalidInput);
}

TEST(Network, FindsTypedHandles) {
  Network net;
  net.AddScalar("a", 1.0);
  EXPECT_EQ(net.Value(net.Find<dn::Scalar>("a")), 1.0);
  EXPECT_THAT([&] { net.Find<Vec<3>>("a"); },
              ThrowsMessage<InvalidInput>(HasSubstr("different kind")));
}

TEST(Network, FindsByNameOrNamesTheNearest) {
  Network net;
  net.AddVector<1>("gyro bias", Scalar(0.0));
  const auto lever = net.AddVector<1>("lever arm", Scalar(0.0));
  EXPECT_EQ(net.Find("lever arm"), lever.id);
  EXPECT_THAT([&] { net.Find("lever am"); },
              ThrowsMessage<InvalidInput>(HasSubstr("the nearest name is 'lever arm'")));
}

TEST(Network, RejectsBadFactors) {
  Network net;
  const auto a = net.AddVector<1>("a", Scalar(0.0));
  const auto b = net.AddVector<1>("b", Scalar(0.0));
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto gap = [](std::vector<BlockKind> kinds, int residuals = 1) {
    return std::make_shared<RunTimeGap>(std::move(kinds), residuals);
  };
  const BlockKind kOne = Vec<1>::kKind;
  EXPECT_THAT(
      [&] {
        net.AddFactor(gap({kOne, kOne}), {a.id});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("takes 2 blocks, 1 given")));
  EXPECT_THAT(
      [&] {
        net.AddFactor(gap({kOne, kOne}), {a.id, p.id});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'p' is of the wrong kind for argument 1")));
  EXPECT_THAT(
      [&] {
        net.AddFactor(gap({kOne, kOne}), {a.id, a.id});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'a' is given twice")));
  EXPECT_THROW(net.AddFactor(gap({kOne, kOne}), {a.id, 17}), InvalidInput);
  EXPECT_THROW(net.AddFactor(gap({}), {}), InvalidInput);
  EXPECT_THROW(net.AddFactor(gap({kOne, kOne}, 0), {a.id, b.id}), InvalidInput);
  EXPECT_THROW(net.AddFactor(nullptr, {a.id}), InvalidInput);
  EXPECT_EQ(net.num_factors(), 0);

  const FactorId id = net.AddFactor(gap({kOne, kOne}), {a.id, b.id});
  EXPECT_THROW(net.ReplaceFactor(id, gap({kOne, Vec<3>::kKind})), InvalidInput);
  EXPECT_THROW(net.ReplaceFactor(id, gap({kOne, kOne}, 2)), InvalidInput);
  EXPECT_THROW(net.ReplaceFactor(id, nullptr), InvalidInput);
  EXPECT_NO_THROW(net.ReplaceFactor(id, gap({kOne, kOne})));
  EXPECT_THROW(net.SetActive(5, false), InvalidInput);
}

// A factor whose kinds are known only at run time takes handles, as any other factor does.
TEST(Network, AddsRunTimeFactorsByHandle) {
  Network net;
  const auto a = net.AddVector<1>("a", Scalar(3.0));
  const auto b = net.AddVector<1>("b", Scalar(1.0));
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const RunTimeGap gap({Vec<1>::kKind, Vec<1>::kKind});
  const FactorId id = net.Add(gap, a, b);
  Eigen::VectorXd r;
  ASSERT_TRUE(net.EvaluateFactor(id, &r));
  EXPECT_EQ(r[0], 2.0);
  EXPECT_THAT([&] { net.Add(gap, a, p); },
              ThrowsMessage<InvalidInput>(HasSubstr("'p' is of the wrong kind for argument 1")));
  EXPECT_THAT([&] { net.Add(gap, a); },
              ThrowsMessage<InvalidInput>(HasSubstr("takes 2 blocks, 1 given")));
}

TEST(Network, RejectsBadLossesAndLabels) {
  Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto b = net.AddVector<1>("b", Scalar(0.0));
  const FactorId id = net.Add(Gap{}, p, b);
  for (const double width : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(net.SetLoss(id, {Loss::Type::kHuber, width}), InvalidInput) << width;
  }
  EXPECT_EQ(net.factor(id).loss.type, Loss::Type::kNone);
  BlockLabel label;
  label.components = {"east", "north"};
  EXPECT_THAT([&] { net.SetLabel(p.id, label); },
              ThrowsMessage<InvalidInput>(HasSubstr("names 2 components, the block has 3")));
  label.components.push_back("up");
  net.SetLabel(p.id, label);
  EXPECT_EQ(net.block(p.id).label.components[2], "up");
}

TEST(Network, TagsFactorsByGroup) {
  Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto b = net.AddVector<1>("b", Scalar(0.0));
  const FactorId first = net.Add(Gap{}, p, b), second = net.Add(Gap{}, p, b),
                 third = net.Add(Gap{}, p, b);
  net.Tag(first, "gnss", 1.0);
  net.Tag(second, "lidar", 2.0);
  net.Tag(third, "gnss", 3.0);
  ASSERT_EQ(net.groups().size(), 3U);
  EXPECT_EQ(net.group(second).name, "lidar");
  EXPECT_EQ(net.factor(first).group, net.factor(third).group);
  EXPECT_EQ(net.factor(second).t_s, 2.0);
}

TEST(Network, NamesTheRowsOfAFactor) {
  Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto b = net.AddVector<1>("b", Scalar(0.0));
  const FactorId id = net.Add(Gap{}, p, b), other = net.Add(Gap{}, p, b);
  net.Tag(id, {"altimeter", {{"up"}}}, 1.0);
  EXPECT_EQ(net.group(id).Channel(0), "altimeter");
  EXPECT_EQ(net.group(id).QuantityAndAxis(0), "up");
  net.Tag(other, "altimeter", 2.0);
  EXPECT_EQ(net.group(other).Axis(0), "0") << "no names were given";
  EXPECT_NE(net.factor(id).group, net.factor(other).group);
  EXPECT_THAT(([&] {
                net.Tag(id, FactorGroup{"gnss", {{"east"}, {"north"}}}, 1.0);
              }),
              ThrowsMessage<InvalidInput>(HasSubstr("names 2 residuals, factor 0 has 1")));
  EXPECT_EQ(net.group(id).name, "altimeter") << "unchanged";
}

TEST(FactorGroup, NamesChannelsByThatWhichTellsThemApart) {
  const FactorGroup inertial{"inertial", {{"x", "gyro"}, {"y", "velocity"}}};
  EXPECT_EQ(inertial.Channel(0), "inertial gyro");
  EXPECT_EQ(inertial.Axis(1), "y");
  EXPECT_EQ(inertial.QuantityAndAxis(1), "velocity_y");
  const FactorGroup process{"bias process", {{"x"}}, "gyro", FactorGroup::Kind::kProcess};
  EXPECT_EQ(process.Channel(0), "gyro bias process");
  EXPECT_EQ(process.QuantityAndAxis(0), "x");
  EXPECT_TRUE(process.measured());
  EXPECT_FALSE((FactorGroup{"prior", {}, {}, FactorGroup::Kind::kPrior}.measured()));
}

}  // namespace dn::core_test
