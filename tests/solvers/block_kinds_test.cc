#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "testing/random.h"

namespace dn::solvers_test {

constexpr double kKindsTolerance =
    1e-9;  ///< relative, for a covariance computed in two equivalent ways

/// Residual of a relative pose, for separate blocks and for poses.
struct Relative {
  Transform<double> T_ij;

  template <class A, class B>
  auto operator()(const A& T_mi, const B& T_mj) const {
    return (T_ij.Inverse() * T_mi.Inverse() * T_mj).ToVector();
  }
  template <class Q, class P>
  auto operator()(const Q& q_mi, const P& p_mi, const Q& q_mj, const P& p_mj) const {
    using Pose = Transform<typename P::Scalar>;
    return (*this)(Pose(q_mi, p_mi), Pose(q_mj, p_mj));
  }
};

// Builds the same chain with a loop twice: with each pose as one block, and with rotation and
// translation as separate blocks. Values and covariances must agree, rotation first.
TEST(Pose, IsARotationAndATranslation) {
  std::mt19937 rng(5);
  const auto random = [&](double angle, double length) {
    return Transform<double>(Exp(testing::RandomVector(rng, angle)),
                             testing::RandomVector(rng, length));
  };
  Network poses, pairs;
  std::vector<Block<Pose>> T;
  std::vector<Block<Rotation>> q;
  std::vector<Block<Vec<3>>> p;
  std::vector<Transform<double>> truth;
  constexpr int kPoses = 8;
  for (int i = 0; i < kPoses; ++i) {
    const std::string name = std::to_string(i);
    truth.push_back(random(2.0, 10.0));
    const Transform<double> start = truth.back() * random(0.05, 0.3);
    T.push_back(poses.AddPose(name, start));
    q.push_back(pairs.AddRotation("q" + name, start.q));
    p.push_back(pairs.AddVector<3>("p" + name, start.p));
  }
  poses.SetValue(T[0], truth[0]);
  pairs.SetValue(q[0], truth[0].q);
  pairs.SetValue(p[0], truth[0].p);
  poses.Hold(T[0]);
  pairs.Hold(q[0]);
  pairs.Hold(p[0]);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << 1e-3, 2e-3, 1e-3, 0.02, 0.03, 0.05;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const std::size_t j = (i + 1) % kPoses;
    const Relative measured{truth[i].Inverse() * truth[j] * random(1e-3, 0.02)};
    poses.Add(measured, Noise<6>::Sigma(sigma), T[i], T[j]);
    pairs.Add(measured, Noise<6>::Sigma(sigma), q[i], p[i], q[j], p[j]);
  }
  ASSERT_TRUE(Solve(poses).converged);
  ASSERT_TRUE(Solve(pairs).converged);
  const Marginals of_poses(poses), of_pairs(pairs);
  for (std::size_t i = 1; i < kPoses; ++i) {
    EXPECT_LT((poses.Value(T[i]).p - pairs.Value(p[i])).norm(), 1e-9);
    EXPECT_LT(poses.Value(T[i]).q.angularDistance(pairs.Value(q[i])), 1e-7);
    Eigen::Matrix<double, 6, 6> C;
    C << of_pairs.Covariance(q[i], q[i]), of_pairs.Covariance(q[i], p[i]),
        of_pairs.Covariance(p[i], q[i]), of_pairs.Covariance(p[i], p[i]);
    EXPECT_LT((of_poses.Covariance(T[i]) - C).norm(), kKindsTolerance * C.norm() * 1e2);
  }
}

/// A unit vector in the plane, perturbed by an angle in rad.
struct Direction {
  static constexpr int kSize = 2, kTangentSize = 1;
  template <class T>
  static void Plus(const T* x, const T* d, T* out) {
    using std::cos;
    using std::sin;
    const T c = cos(d[0]), s = sin(d[0]), x0 = x[0];
    out[0] = x0 * c - x[1] * s;
    out[1] = x[1] * c + x0 * s;
  }
  static void Minus(const double* y, const double* x, double* d) {
    d[0] = std::atan2(x[0] * y[1] - x[1] * y[0], x[0] * y[0] + x[1] * y[1]);
  }
};

// Three bearings with sigma 0.02 rad: the solution is their mean, with sigma 0.02 / sqrt(3).
TEST(ManifoldKind, IsSolvedWithItsCovariance) {
  Network net;
  const auto d = net.AddBlock<Direction>("d", {1.0, 0.0});
  for (const double bearing : {1.9, 2.0, 2.1}) {
    const Eigen::Vector2d seen(std::cos(bearing), std::sin(bearing));
    const auto angle = [seen](const auto& x) {
      using std::atan2;
      return atan2(seen[0] * x[1] - seen[1] * x[0], seen[0] * x[0] + seen[1] * x[1]);
    };
    net.Add(angle, Noise<1>::Sigma(0.02), d);
  }
  ASSERT_TRUE(Solve(net).converged);
  EXPECT_NEAR(std::atan2(net.Value(d)[1], net.Value(d)[0]), 2.0, 1e-10);
  EXPECT_NEAR(net.Value(d).norm(), 1.0, 1e-12);
  EXPECT_NEAR(std::sqrt(MarginalCovariance(net, d)(0, 0)), 0.02 / std::sqrt(3.0), 1e-12);
}

// Removing a factor must give the adjustment of the remaining factors.
TEST(Network, RemovedFactorsDoNotCount) {
  Network net;
  const auto x = net.AddScalar("x", 0.0);
  const auto prior = [](double z) { return [z](const auto& v) { return v - z; }; };
  const FactorId wrong = net.Add(prior(1e6), Noise<1>::Sigma(1.0), x);
  net.Add(prior(1.0), Noise<1>::Sigma(1.0), x);
  net.Add(prior(3.0), Noise<1>::Sigma(1.0), x);
  net.RemoveFactor(wrong);
  EXPECT_TRUE(Solve(net).converged);
  EXPECT_NEAR(net.Value(x), 2.0, 1e-7);  // 1e-15 of the cost
  EXPECT_NEAR(MarginalCovariance(net, x)(0, 0), 0.5, 1e-14);
  EXPECT_EQ(EvaluateCost(net).residuals, 2);
}

}  // namespace dn::solvers_test
