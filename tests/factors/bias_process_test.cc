#include <dn/error.h>
#include <dn/factors/bias_process.h>
#include <dn/factors/prior.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "testing/factor_consistency.h"

namespace dn::factors_test {

using testing::RandomVector;
using testing::State;

/// Variance q and transition factor phi of a step, computed from the factor's Jacobians.
struct Step {
  double phi, q;
};

Step ProcessStep(const FactorBase& f) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const double* x[] = {zero.data(), zero.data()};
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> J_k, J_next;
  double* J[] = {J_k.data(), J_next.data()};
  EXPECT_TRUE(f.Evaluate(x, r.data(), J));
  EXPECT_TRUE(J_next.isDiagonal(0.0) && J_k.isDiagonal(0.0));
  return {-J_k(1, 1) / J_next(1, 1), 1.0 / (J_next(1, 1) * J_next(1, 1))};
}

// Hand calculation: over tau ln 2 the process decays to half, and the driving noise has 3/4 of the
// stationary variance.
TEST(GaussMarkovEdge, ResidualOverOneHalvingTime) {
  const GaussMarkovEdge f(2.0, 100.0, 100.0 * std::log(2.0));
  const Eigen::Vector3d x_k(1.0, 2.0, 3.0), x_next(1.0, 1.0, 0.0);
  Eigen::Vector3d r;
  ASSERT_TRUE(f.Residual(x_k.data(), x_next.data(), r.data()));
  EXPECT_LE((r - Eigen::Vector3d(0.5, 0.0, -1.5) / std::sqrt(3.0)).norm(), 1e-15);
  EXPECT_NEAR(f.phi(), 0.5, 1e-15);
}

// Hand calculation: a density of 0.3 over 4 s gives 0.6.
TEST(RandomWalkEdge, ResidualIsTheChange) {
  const RandomWalkEdge f(0.3, 4.0);
  const Eigen::Vector3d x_k(1.0, 2.0, 3.0), x_next(1.6, 2.0, 1.8);
  Eigen::Vector3d r;
  ASSERT_TRUE(f.Residual(x_k.data(), x_next.data(), r.data()));
  EXPECT_LE((r - Eigen::Vector3d(1.0, 0.0, -2.0)).norm(), 1e-14);
}

TEST(BiasProcess, JacobiansAgreeAtRandomStates) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> exponent(-3.0, 3.0);
    const double sigma = std::pow(10.0, exponent(rng)), tau_s = std::pow(10.0, exponent(rng));
    const std::vector<Eigen::VectorXd> x{RandomVector(rng, 1.0), RandomVector(rng, 1.0)};
    const GaussMarkovEdge gauss_markov(sigma, tau_s, 1.0);
    testing::ExpectFactorConsistent(gauss_markov, x, testing::Autodiff(gauss_markov));
    const RandomWalkEdge random_walk(sigma, tau_s);
    testing::ExpectFactorConsistent(random_walk, x, testing::Autodiff(random_walk));
  }
}

// A chain that starts with its stationary distribution keeps it at every node, even with steps of
// unequal length. Its correlation is exp(-dt / tau).
TEST(GaussMarkovEdge, ChainIsStationary) {
  constexpr double kSigma = 0.7, kTauS = 50.0;
  const std::vector<double> steps_s{1.0, 200.0, 0.01, 30.0, 5.0};
  const auto n = static_cast<Eigen::Index>(steps_s.size() + 1);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  information(0, 0) = 1.0 / (kSigma * kSigma);
  std::vector<double> t_s{0.0};
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    const double dt_s = steps_s[static_cast<std::size_t>(k)];
    const Step step = ProcessStep(GaussMarkovEdge(kSigma, kTauS, dt_s));
    const Eigen::Vector2d j(-step.phi, 1.0);
    information.block<2, 2>(k, k) += j * j.transpose() / step.q;
    t_s.push_back(t_s.back() + dt_s);
  }
  const Eigen::MatrixXd covariance = information.inverse();
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const double dt_s =
          std::abs(t_s[static_cast<std::size_t>(i)] - t_s[static_cast<std::size_t>(k)]);
      const double expected = kSigma * kSigma * std::exp(-dt_s / kTauS);
      EXPECT_NEAR(covariance(i, k), expected, 1e-10) << i << " " << k;
    }
  }
}

TEST(GaussMarkovEdge, LongCorrelationTimeIsARandomWalk) {
  constexpr double kDensity = 0.03, kTauS = 1e12, kStepS = 2.0;
  // Equal driving noise: q dt = 2 sigma^2 / tau dt.
  const double sigma = kDensity * std::sqrt(kTauS / 2.0);
  const Step gauss_markov = ProcessStep(GaussMarkovEdge(sigma, kTauS, kStepS));
  const Step random_walk = ProcessStep(RandomWalkEdge(kDensity, kStepS));
  EXPECT_NEAR(gauss_markov.phi, random_walk.phi, 1e-11);
  EXPECT_NEAR(gauss_markov.q / random_walk.q, 1.0, 1e-11);
  EXPECT_EQ(random_walk.phi, 1.0);
  EXPECT_NEAR(random_walk.q, kDensity * kDensity * kStepS, 1e-17);
}

TEST(BiasProcess, TwoStepsComposeToOne) {
  const auto composed = [](const Step& a, const Step& b) -> Step {
    return {b.phi * a.phi, b.phi * b.phi * a.q + b.q};
  };
  const Step gauss_markov = composed(ProcessStep(GaussMarkovEdge(0.5, 20.0, 3.0)),
                                     ProcessStep(GaussMarkovEdge(0.5, 20.0, 8.0)));
  const Step gauss_markov_one = ProcessStep(GaussMarkovEdge(0.5, 20.0, 11.0));
  EXPECT_NEAR(gauss_markov.phi, gauss_markov_one.phi, 1e-15);
  EXPECT_NEAR(gauss_markov.q, gauss_markov_one.q, 1e-15);

  const Step random_walk =
      composed(ProcessStep(RandomWalkEdge(0.5, 3.0)), ProcessStep(RandomWalkEdge(0.5, 8.0)));
  EXPECT_NEAR(random_walk.q, ProcessStep(RandomWalkEdge(0.5, 11.0)).q, 1e-14);
}

TEST(BiasProcess, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, nan, inf}) {
    EXPECT_THROW(GaussMarkovEdge(bad, 1.0, 1.0), InvalidInput);
    EXPECT_THROW(GaussMarkovEdge(1.0, bad, 1.0), InvalidInput);
    EXPECT_THROW(GaussMarkovEdge(1.0, 1.0, bad), InvalidInput);
    EXPECT_THROW(RandomWalkEdge(bad, 1.0), InvalidInput);
    EXPECT_THROW(RandomWalkEdge(1.0, bad), InvalidInput);
  }
  EXPECT_THROW(RandomWalkEdge(1e-200, 1.0), InvalidInput);  // the variance underflows to zero
}

}  // namespace dn::factors_test
