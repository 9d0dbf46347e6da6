#include <dn/network.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "testing/factor_consistency.h"
#include "testing/random.h"

namespace dn::core_test {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kKindTolerance = 1e-12;  ///< rounding of a few products

/// A unit vector in the plane, perturbed by an angle in rad.
struct Direction {
  static constexpr int kSize = 2, kTangentSize = 1;

  template <class T>
  static void Plus(const T* x, const T* d, T* x_plus_d) {
    using std::cos;
    using std::sin;
    x_plus_d[0] = x[0] * cos(d[0]) - x[1] * sin(d[0]);
    x_plus_d[1] = x[1] * cos(d[0]) + x[0] * sin(d[0]);
  }

  static void Minus(const double* y, const double* x, double* y_minus_x) {
    y_minus_x[0] = std::atan2(x[0] * y[1] - x[1] * y[0], x[0] * y[0] + x[1] * y[1]);
  }
};

/// A positive number perturbed in its logarithm, with an analytic Jacobian; its value and view are
/// doubles.
struct Positive {
  using Value = double;
  static constexpr int kSize = 1, kTangentSize = 1;
  static void Plus(const double* x, const double* d, double* out) { *out = *x * std::exp(*d); }
  static void Minus(const double* y, const double* x, double* out) { *out = std::log(*y / *x); }
  static void PlusJacobian(const double* x, double* J) { *J = *x; }
};

/// Direction with mistakes.
struct ExchangedMinus : Direction {
  static void Minus(const double* y, const double* x, double* y_minus_x) {
    Direction::Minus(x, y, y_minus_x);
  }
};
struct MinusInDegrees : Direction {
  static void Minus(const double* y, const double* x, double* y_minus_x) {
    Direction::Minus(y, x, y_minus_x);
    y_minus_x[0] *= 180.0 / M_PI;
  }
};
struct PlusOffTheCircle : Direction {
  template <class T>
  static void Plus(const T* x, const T* d, T* x_plus_d) {
    x_plus_d[0] = x[0] - x[1] * d[0];
    x_plus_d[1] = x[1] + x[0] * d[0];
  }
};
struct TripleJacobian : Positive {
  static void PlusJacobian(const double* x, double* J) { *J = 3.0 * *x; }
};
struct PlusWithAnOffset : Positive {
  static void Plus(const double* x, const double* d, double* out) {
    *out = *x * std::exp(*d + 1.0);
  }
};

template <class Kind>
void ExpectRefused(const BlockValue<Kind>& value, const std::string& text) {
  Network net;
  EXPECT_THAT([&] { net.AddBlock<Kind>("north", value); },
              ThrowsMessage<InvalidInput>(::testing::AllOf(HasSubstr("'north'"), HasSubstr(text))));
  EXPECT_EQ(net.num_blocks(), 0);
}

TEST(ManifoldKind, IsRefusedIfItsFunctionsContradictEachOther) {
  ExpectRefused<ExchangedMinus>({0.6, 0.8}, "Minus(Plus(x, d), x) is -0.1 in coordinate 0");
  ExpectRefused<MinusInDegrees>({0.6, 0.8}, "but d is 0.1");
  ExpectRefused<PlusOffTheCircle>({0.6, 0.8}, "Minus(Plus(x, d), x)");
  ExpectRefused<TripleJacobian>(2.0, "PlusJacobian is 6 in row 0, column 0, but the derivative");
  ExpectRefused<PlusWithAnOffset>(2.0, "Plus(x, 0)");
}

TEST(ManifoldKind, IsCheckedOncePerNetwork) {
  Network net;
  net.AddBlock<Direction>("a", {0.6, 0.8});
  net.AddBlock<Direction>("b", {1.0, 0.0});
  Network copy = net;
  copy.AddPose("pose", {Eigen::Quaterniond::Identity(), {4e6, 1e6, 5e6}});
  EXPECT_EQ(copy.num_blocks(), 3);
}

template <class Kind>
void ExpectManifold(const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
  const BlockKind kind = MakeBlockKind<Kind>();
  ASSERT_EQ(x.size(), kind.stored_size);
  Eigen::VectorXd y(x.size()), back(d.size());
  Plus(kind, x.data(), d.data(), y.data());
  Minus(kind, y.data(), x.data(), back.data());
  EXPECT_LE((back - d).norm(), kKindTolerance);

  const Eigen::MatrixXd J = PlusJacobian(kind, x.data());
  constexpr double kStep = 1e-6;
  for (Eigen::Index k = 0; k < d.size(); ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(d.size(), k), minus = -step;
    Eigen::VectorXd plus(x.size()), less(x.size());
    Plus(kind, x.data(), step.data(), plus.data());
    Plus(kind, x.data(), minus.data(), less.data());
    EXPECT_LE(((plus - less) / (2.0 * kStep) - J.col(k)).norm(), 1e-9);
  }
  const auto n = static_cast<Eigen::Index>(kind.tangent_size);
  EXPECT_TRUE(
      (TangentLift(kind, x.data()) * J).isApprox(Eigen::MatrixXd::Identity(n, n), kKindTolerance));
}

TEST(ManifoldKind, OfAUserOrThePose) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const double angle = testing::RandomVector(rng, 3.0).x();
    ExpectManifold<Direction>(Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                              Eigen::Matrix<double, 1, 1>(0.7));
    ExpectManifold<Positive>(Eigen::Matrix<double, 1, 1>(std::exp(angle)),
                             Eigen::Matrix<double, 1, 1>(-0.4));
    Eigen::VectorXd x(7), d(6);
    x << testing::RandomRotation(rng).coeffs(), testing::RandomVector(rng, 9.0);
    d << testing::RandomVector(rng, 1.0), testing::RandomVector(rng, 9.0);
    ExpectManifold<Pose>(x, d);
  }
}

TEST(ManifoldKind, SeenByFunctionsAndByValue) {
  Network net;
  const auto north = net.AddBlock<Direction>("north", {0.6, 0.8});
  const auto scale = net.AddBlock<Positive>("scale", 2.0);
  const auto along = [](const auto& d, const auto& s) { return s * (2.0 * d[0] - d[1]); };
  const FactorId id = net.Add(along, Noise<1>::Sigma(1.0), north, scale);
  testing::ExpectFactorConsistent(*net.factor(id).factor,
                                  {Eigen::Vector2d(0.6, 0.8), Eigen::Matrix<double, 1, 1>(2.0)});
  EXPECT_EQ(net.Value(scale), 2.0);
  EXPECT_EQ(net.Value(north), Eigen::Vector2d(0.6, 0.8));
  EXPECT_EQ(net.num_free_parameters(), 2);
}

/// r = angle of the direction x, with an analytic tangent Jacobian.
class Bearing final : public Factor<Bearing, 1, Direction> {
 public:
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    r[0] = std::atan2(x[0][1], x[0][0]);
    Put<0>(x, J, Eigen::Matrix<double, 1, 1>(1.0));
    return true;
  }
};

TEST(ManifoldKind, PutLiftsTangentJacobians) {
  testing::ExpectFactorConsistent(Bearing{}, {Eigen::Vector2d(0.6, 0.8)});
}

TEST(Pose, IsOnItsManifold) {
  Network net;
  const Transform<double> pose(Eigen::Quaterniond(2.0, 0.0, 0.0, 0.0), {1.0, 2.0, 3.0});
  const auto b = net.AddPose("b", pose);
  EXPECT_EQ(net.Value(b).q.w(), 1.0);
  EXPECT_EQ(net.Value(b).p, pose.p);
  EXPECT_EQ(net.num_free_parameters(), 6);
  const Transform<double> none(Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), {1.0, 2.0, 3.0});
  EXPECT_THAT([&] { net.AddPose("none", none); },
              ThrowsMessage<InvalidInput>(HasSubstr("'none' is not on its manifold")));
  EXPECT_THROW(net.SetValue(b, none), InvalidInput);
}

TEST(Transform, ComposesAndInverts) {
  std::mt19937 rng(1);
  const Transform<double> a(testing::RandomRotation(rng), testing::RandomVector(rng, 5.0));
  const Transform<double> b(testing::RandomRotation(rng), testing::RandomVector(rng, 5.0));
  const Eigen::Vector3d x = testing::RandomVector(rng, 5.0);
  EXPECT_LE(((a * b) * x - a * (b * x)).norm(), kKindTolerance);
  EXPECT_LE((a * (a.Inverse() * x) - x).norm(), kKindTolerance);
  EXPECT_LE((a.Inverse() * a).ToVector().norm(), kKindTolerance);
}

}  // namespace dn::core_test
