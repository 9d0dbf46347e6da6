#include <dn/network.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "testing/factor_consistency.h"
#include "testing/random.h"

namespace dn::core_test {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Residual and tangent Jacobians of the last factor of a network.
struct Evaluated {
  bool defined = false;
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
};

/// Compares the tangent Jacobians with numeric differentiation. The residual may differ by rounding
/// from that without Jacobians, because the order of summation differs.
void ExpectDerivatives(const FactorBase& factor, const std::vector<Eigen::VectorXd>& x) {
  const testing::internal::Evaluation all =
      testing::internal::Evaluate([&](auto... args) { return factor.Evaluate(args...); }, factor, x,
                                  std::vector<bool>(x.size(), true));
  ASSERT_TRUE(all.ok);
  testing::internal::ExpectNumeric(factor, x, all);
}

Evaluated Evaluate(const Network& net, FactorId id) {
  Evaluated e;
  e.defined = net.EvaluateFactor(id, &e.r, &e.J);
  return e;
}

// (3, 4, 12) has length 13, which grows by 1 per unit along the vector.
TEST(FunctionFactor, ANumberOfOneVector) {
  Network net;
  const auto p = net.AddVector<3>("p", {3.0, 4.0, 12.0});
  const FactorId id =
      net.Add([](const auto& x) { return x.norm() - 12.0; }, Noise<1>::Sigma(0.5), p);
  const Evaluated e = Evaluate(net, id);
  ASSERT_TRUE(e.defined);
  EXPECT_DOUBLE_EQ(e.r[0], 2.0);
  EXPECT_TRUE(e.J[0].isApprox(Eigen::RowVector3d(3.0, 4.0, 12.0) * (2.0 / 13.0), 1e-15));
}

TEST(FunctionFactor, WhitensByAFullCovariance) {
  Eigen::Matrix2d C;
  C << 4.0, 1.0, 1.0, 9.0;
  Network net;
  const auto a = net.AddVector<2>("a", {1.0, 2.0});
  const auto s = net.AddScalar("s", 3.0);
  const auto scaled = [](const auto& x, const auto& factor) { return (factor * x).eval(); };
  const FactorId by_covariance = net.Add(scaled, Noise<2>::Covariance(C), a, s);
  const FactorId by_information = net.Add(scaled, Noise<2>::Information(C.inverse()), a, s);
  const Eigen::Vector2d f(3.0, 6.0);
  for (const FactorId id : {by_covariance, by_information}) {
    const Evaluated e = Evaluate(net, id);
    EXPECT_NEAR(e.r.squaredNorm(), f.dot(C.inverse() * f), 1e-13);
    EXPECT_TRUE(
        (e.J[1].transpose() * e.J[1])
            .isApprox(Eigen::RowVector2d(1.0, 2.0) * C.inverse() * Eigen::Vector2d(1.0, 2.0),
                      1e-13));
  }
}

// Pose j seen from pose i, as a function of six residuals, compared with numeric differences.
TEST(FunctionFactor, ARelativePose) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const auto pose = [&] {
      return Transform<double>(testing::RandomRotation(rng), testing::RandomVector(rng, 10.0));
    };
    const Transform<double> measured = pose();
    const auto between = [measured](const auto& T_mi, const auto& T_mj) {
      return (measured.Inverse() * T_mi.Inverse() * T_mj).ToVector();
    };
    Network net;
    const auto i = net.AddPose("i", pose()), j = net.AddPose("j", pose());
    const FactorId id = net.Add(between, Noise<6>::Sigma(0.1), i, j);
    std::vector<Eigen::VectorXd> x;
    for (const BlockId b : {i.id, j.id}) {
      x.emplace_back(Eigen::Map<const Eigen::VectorXd>(net.block(b).value.get(), 7));
    }
    ExpectDerivatives(*net.factor(id).factor, x);
    net.SetValue(j, net.Value(i) * measured);
    EXPECT_LT(Evaluate(net, id).r.norm(), 1e-12);
  }
}

TEST(FunctionFactor, RotationsAreQuaternions) {
  Network net;
  const auto q = net.AddRotation("q", Exp(Eigen::Vector3d(0.1, -0.2, 0.3)));
  const auto left = net.AddLeftRotation("l", Exp(Eigen::Vector3d(-0.3, 0.1, 0.2)));
  const auto product = [](const auto& a, const auto& b) { return Log(a * b); };
  const FactorId id = net.Add(product, Noise<3>::Sigma(1.0), q, left);
  const std::vector<Eigen::VectorXd> x{net.Value(q).coeffs(), net.Value(left).coeffs()};
  ExpectDerivatives(*net.factor(id).factor, x);
}

TEST(FunctionFactor, NothingIsUndefined) {
  Network net;
  const auto x = net.AddScalar("x", 4.0);
  const auto root = [](const auto& v) {
    using std::sqrt;
    using T = std::decay_t<decltype(v)>;
    return v < 0.0 ? std::optional<T>() : std::optional<T>(sqrt(v));
  };
  const FactorId id = net.Add(root, Noise<1>::Sigma(1.0), x);
  EXPECT_EQ(Evaluate(net, id).r[0], 2.0);
  net.SetValue(x, -1.0);
  EXPECT_FALSE(Evaluate(net, id).defined);
  Eigen::VectorXd r;
  EXPECT_FALSE(net.EvaluateFactor(id, &r));
}

TEST(FunctionFactor, AListOfAnyNumberOfBlocks) {
  for (const int n : {1, 2, 5, 9}) {
    SCOPED_TRACE(n);
    Network net;
    std::vector<Block<Vec<3>>> points;
    std::vector<Eigen::VectorXd> x;
    std::mt19937 rng(static_cast<unsigned>(n));
    for (int i = 0; i < n; ++i) {
      x.emplace_back(testing::RandomVector(rng, 5.0));
      points.push_back(net.AddVector<3>(std::to_string(i), Eigen::Vector3d(x.back())));
    }
    const auto mean_square = [](const auto& p) {
      auto sum = p[0].squaredNorm();
      for (int i = 1; i < p.size(); ++i) sum += p[i].squaredNorm();
      return sum / static_cast<double>(p.size());
    };
    const FactorId id = net.Add(mean_square, Noise<1>::Sigma(2.0), points);
    ExpectDerivatives(*net.factor(id).factor, x);
    double sum = 0.0;
    for (const Eigen::VectorXd& p : x) sum += p.squaredNorm();
    EXPECT_NEAR(Evaluate(net, id).r[0], 0.5 * sum / n, 1e-12);
  }
}

/// r = sum of the x of all blocks; the number of blocks is known at run time.
struct Total : DynamicAutoFactor<Total> {
  explicit Total(int n)
      : DynamicAutoFactor(1, std::vector<BlockKind>(static_cast<std::size_t>(n), Vec<2>::kKind)) {}

  template <class T>
  bool Residual(const T* const* x, T* r) const {
    r[0] = T(0.0);
    for (std::size_t i = 0; i < block_kinds().size(); ++i) r[0] += x[i][0] * x[i][1];
    return true;
  }
};

TEST(DynamicAutoFactor, DifferentiatesEveryBlock) {
  for (const int n : {1, 3, 8}) {
    std::vector<Eigen::VectorXd> x;
    for (int i = 0; i < n; ++i) x.emplace_back(Eigen::Vector2d(1.0 + i, 2.0 - i));
    testing::ExpectFactorConsistent(Total(n), x);
  }
}

/// Has two residuals but writes only r[0].
struct HalfWritten : AutoFactor<HalfWritten, 2, Vec<1>> {
  template <class T>
  bool Residual(const T* x, T* r) const {
    r[0] = x[0];
    return true;
  }
};

TEST(AutoFactor, ARowThatIsNotWrittenIsKnown) {
  Network net;
  const auto x = net.AddVector<1>("x", Eigen::Matrix<double, 1, 1>(2.0));
  const FactorId id = net.Add(HalfWritten{}, x);
  const Evaluated e = Evaluate(net, id);
  EXPECT_EQ(e.r[0], 2.0);
  EXPECT_TRUE(IsUnwritten(e.r[1]));
  EXPECT_FALSE(IsUnwritten(std::numeric_limits<double>::quiet_NaN()));
  Eigen::VectorXd r;
  ASSERT_TRUE(net.EvaluateFactor(id, &r));
  EXPECT_TRUE(IsUnwritten(r[1]));
}

TEST(Network, NamesTheFactorThatThrows) {
  Network net;
  const auto x = net.AddScalar("x", 1.0);
  const auto f = [](const auto& v) {
    if (v > 0.0) throw std::out_of_range("table ends at 0");
    return v;
  };
  const FactorId id = net.Add(f, Noise<1>::Sigma(1.0), x);
  net.Tag(id, "table", 3.0);
  Eigen::VectorXd r;
  EXPECT_THAT([&] { net.EvaluateFactor(id, &r); },
              ThrowsMessage<InvalidInput>(
                  HasSubstr("factor 0 (table, 3.000 s) on 'x' throws: table ends at 0")));
}

TEST(Network, RemovesFactorsAndKeepsTheIdsOfTheOthers) {
  Network net;
  const auto x = net.AddScalar("x", 1.0);
  const auto prior = [](const auto& v) { return v * 1.0; };
  const FactorId first = net.Add(prior, Noise<1>::Sigma(1.0), x);
  const FactorId second = net.Add(prior, Noise<1>::Sigma(0.5), x);
  net.RemoveFactor(first);
  EXPECT_EQ(net.num_factors(), 2);
  EXPECT_FALSE(net.factor(first).active);
  EXPECT_EQ(Evaluate(net, second).r[0], 2.0);
  EXPECT_NE(net.Add(prior, Noise<1>::Sigma(1.0), x), first);
  Eigen::VectorXd r;
  EXPECT_THAT([&] { net.SetActive(first, true); },
              ThrowsMessage<InvalidInput>(HasSubstr("factor 0 was removed")));
  EXPECT_THROW(net.EvaluateFactor(first, &r), InvalidInput);
  EXPECT_THROW(net.RemoveFactor(first), InvalidInput);
  EXPECT_THROW(net.SetLoss(first, Loss::Huber(1.0)), InvalidInput);
}

TEST(Network, ACopyIsIndependent) {
  Network net;
  const auto x = net.AddScalar("x", 1.0);
  const FactorId id = net.Add([](const auto& v) { return v * 1.0; }, Noise<1>::Sigma(1.0), x);
  net.SetLoss(id, Loss::Cauchy(2.0));
  Network copy = net;
  copy.SetValue(x, 5.0);
  copy.Hold(x);
  copy.SetActive(id, false);
  copy.AddScalar("y", 2.0);
  EXPECT_EQ(net.Value(x), 1.0);
  EXPECT_FALSE(net.block(x.id).held);
  EXPECT_TRUE(net.factor(id).active);
  EXPECT_EQ(net.num_blocks(), 1);
  EXPECT_EQ(copy.Find("y"), 1);
  EXPECT_EQ(copy.factor(id).loss.type, Loss::Type::kCauchy);
  net = copy;
  EXPECT_EQ(net.Value(x), 5.0);
  net.SetValue(x, 6.0);
  EXPECT_EQ(copy.Value(x), 5.0);
}

}  // namespace dn::core_test
