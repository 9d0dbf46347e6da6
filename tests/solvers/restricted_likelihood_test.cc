#include <dn/error.h>
#include <dn/solvers/restricted_likelihood.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"
#include "solvers/step_factor.h"

namespace dn::solvers_test {

using testing::MakeVectorPrior;
using testing::Step;

constexpr double kPositionSigma = 0.5, kStepSigma = 0.2;

/// A chain of noisy steps with measured positions; the true noise of the positions is
/// `position_ratio` times the stated noise.
struct NoisyChain {
  Network net;
  std::vector<FactorId> positions;

  NoisyChain(unsigned seed, int nodes, double position_ratio = 1.0) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) {
      const double x = normal(rng), y = normal(rng), z = normal(rng);
      return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
    };
    Block<Vec<3>> before;
    for (int k = 0; k < nodes; ++k) {
      const auto x = net.AddVector<3>("x/" + std::to_string(k), Eigen::Vector3d::Zero());
      positions.push_back(
          net.Add(MakeVectorPrior<3>(noise(position_ratio * kPositionSigma), kPositionSigma), x));
      Step step;
      step.z = noise(kStepSigma);
      step.sigma = kStepSigma;
      if (k > 0) net.Add(step, before, x);
      before = x;
    }
  }

  /// Returns 1 for the rows of the positions and 0 for the others.
  Eigen::VectorXd PositionShare(const LinearizedNetwork& linearized) const {
    Eigen::VectorXd share = Eigen::VectorXd::Zero(linearized.rows());
    for (const FactorId id : positions) {
      const LinearizedNetwork::FactorRows rows = *linearized.FindRows(id);
      share.segment(rows.first, rows.count).setOnes();
    }
    return share;
  }
};

/// Evaluates the definition with dense matrices.
double DenseLikelihood(const LinearizedNetwork& linearized, const Eigen::VectorXd& variance) {
  const Eigen::Index n = linearized.parameters();
  const Eigen::MatrixXd J = linearized.Times(Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd W = variance.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd N = J.transpose() * W * J;
  const Eigen::MatrixXd P = W - W * J * N.inverse() * J.transpose() * W;
  const Eigen::VectorXd& r = linearized.residual();
  return -0.5 * (r.dot(P * r) + variance.array().log().sum() +
                 2.0 * Eigen::MatrixXd(N.llt().matrixL()).diagonal().array().log().sum());
}

/// Returns shares of various sizes, some of them zero.
Eigen::VectorXd RandomShare(Eigen::Index rows) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> uniform(-0.3, 1.0);
  Eigen::VectorXd share(rows);
  for (double& one : share) one = std::max(0.0, uniform(rng));
  return share;
}

TEST(RestrictedLikelihood, IsItsDefinition) {
  const NoisyChain chain(1, 20, 1.3);
  const LinearizedNetwork linearized(chain.net);
  const Eigen::VectorXd share = RandomShare(linearized.rows());
  const std::vector<double> thetas{-0.6, -0.1, 0.0, 0.4, 2.0, 100.0};
  const VarianceProfile profile = ProfileVariance(linearized, share, thetas, 2);
  const double stated =
      RestrictedLogLikelihood(Marginals(linearized));  // x = 0 is one step away from the solution
  EXPECT_NEAR(stated, DenseLikelihood(linearized, Eigen::VectorXd::Ones(linearized.rows())), 1e-9);
  ASSERT_EQ(profile.theta, thetas);
  for (std::size_t k = 0; k < thetas.size(); ++k) {
    const Eigen::VectorXd variance = 1.0 + thetas[k] * share.array();
    const double dense = DenseLikelihood(linearized, variance);
    EXPECT_NEAR(profile.log_likelihood_ratio[k], dense - stated, 1e-9) << thetas[k];
    const Marginals scaled(linearized.Scaled(variance.cwiseSqrt().cwiseInverse()));
    EXPECT_NEAR(RestrictedLogLikelihood(scaled), dense, 1e-9) << thetas[k];
  }
}

// A non-linear network of poses and a boresight, at its solution.
TEST(RestrictedLikelihood, OfAPoseGraphIsItsDefinition) {
  testing::PoseGraphOptions options;
  options.nodes = 15;
  options.noise = 1.0;
  testing::PoseGraph graph = testing::MakePoseGraph(3, options);
  ASSERT_TRUE(Solve(graph.network).converged);
  const LinearizedNetwork linearized(graph.network);
  const Eigen::VectorXd share = RandomShare(linearized.rows());
  const VarianceProfile profile = ProfileVariance(linearized, share, {0.7});
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(linearized.rows());
  EXPECT_NEAR(profile.log_likelihood_ratio[0],
              DenseLikelihood(linearized, ones + 0.7 * share) - DenseLikelihood(linearized, ones),
              1e-7);
}

TEST(RestrictedLikelihood, IsKnownWhereItWasAskedForBefore) {
  const NoisyChain chain(4, 20, 1.3);
  const LinearizedNetwork linearized(chain.net);
  const Eigen::VectorXd share = RandomShare(linearized.rows());
  VarianceLikelihood likelihood(linearized, share, 2);
  const std::vector<double> first = likelihood.At({0.5, -0.2, 0.5});
  EXPECT_EQ(first[0], first[2]);
  const std::vector<double> then = likelihood.At({3.0, -0.2, 0.0, 0.5});
  EXPECT_EQ(then[1], first[1]);
  EXPECT_EQ(then[3], first[0]);
  EXPECT_EQ(likelihood.At(3.0), then[0]);
  const VarianceProfile profile = ProfileVariance(linearized, share, {3.0, -0.2});
  EXPECT_NEAR(profile.log_likelihood_ratio[0], then[0] - then[2], 1e-10);
  EXPECT_NEAR(profile.log_likelihood_ratio[1], then[1] - then[2], 1e-10);
  EXPECT_THROW(likelihood.At(-1.1), InvalidInput);
  EXPECT_THROW(VarianceLikelihood(linearized, share.head(4)), InvalidInput);
}

// A second scaling takes the noise after the first one as the stated noise.
TEST(RestrictedLikelihood, OfAScaledNetworkGoesOnFromThere) {
  const NoisyChain chain(2, 20);
  const LinearizedNetwork linearized(chain.net);
  const Eigen::VectorXd share = Eigen::VectorXd::Ones(linearized.rows());
  const VarianceProfile profile = ProfileVariance(linearized, share, {1.0, 3.0});
  const LinearizedNetwork twice = linearized.Scaled(share / std::sqrt(2.0));
  EXPECT_NEAR(ProfileVariance(twice, share, {1.0}).log_likelihood_ratio[0],
              profile.log_likelihood_ratio[1] - profile.log_likelihood_ratio[0], 1e-9);
}

TEST(RestrictedLikelihood, PicksTheRightRatio) {
  constexpr int kFlights = 100;
  constexpr double kRatio = 1.5;
  std::vector<double> thetas;
  for (double ratio = 1.0; ratio < 2.2; ratio += 0.05) thetas.push_back(ratio * ratio - 1.0);
  std::vector<double> mean(thetas.size(), 0.0);
  double sum = 0.0, sum2 = 0.0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    const NoisyChain chain(seed, 100, kRatio);
    const LinearizedNetwork linearized(chain.net);
    const VarianceProfile profile =
        ProfileVariance(linearized, chain.PositionShare(linearized), thetas);
    const auto& l = profile.log_likelihood_ratio;
    const double best = std::sqrt(
        1.0 + thetas[static_cast<std::size_t>(std::max_element(l.begin(), l.end()) - l.begin())]);
    sum += best / kFlights;
    sum2 += best * best / kFlights;
  }
  const double sigma = std::sqrt(sum2 - sum * sum);
  EXPECT_LT(sigma, 0.1) << "300 positions determine their noise to some percent";
  EXPECT_NEAR(sum, kRatio, 4.0 * sigma / std::sqrt(kFlights));
}

TEST(VarianceScore, IsTheSlopeOfTheLikelihood) {
  const NoisyChain chain(3, 20, 1.3);
  const LinearizedNetwork linearized(chain.net);
  Eigen::MatrixXd shares(linearized.rows(), 2);
  shares << chain.PositionShare(linearized), RandomShare(linearized.rows());
  const VarianceScore score = ScoreVariances(Marginals(linearized), shares);
  constexpr double kStep = 1e-4;
  for (Eigen::Index k = 0; k < 2; ++k) {
    const auto l = ProfileVariance(linearized, shares.col(k), {-kStep, kStep}).log_likelihood_ratio;
    EXPECT_NEAR(score.u[k], (l[1] - l[0]) / (2.0 * kStep), 1e-5);
  }
}

// Over many flights without a fault, the score has mean zero and its covariance equals the
// information.
TEST(VarianceScore, HasTheInformationAsItsCovariance) {
  constexpr int kFlights = 400;
  const LinearizedNetwork first(NoisyChain(1, 20).net);
  Eigen::MatrixXd shares(first.rows(), 2);
  shares << NoisyChain(1, 20).PositionShare(first), RandomShare(first.rows());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(2);
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(2, 2);
  Eigen::MatrixXd information;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    const VarianceScore score = ScoreVariances(Marginals(NoisyChain(seed, 20).net), shares);
    mean += score.u / kFlights;
    square += score.u * score.u.transpose() / kFlights;
    information = score.information;
  }
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double variance = information(k, k);
    EXPECT_LT(std::abs(mean[k]), 4.0 * std::sqrt(variance / kFlights));
    EXPECT_NEAR(square(k, k) / variance, 1.0, 4.0 * std::sqrt(2.0 / kFlights) + 0.1);
  }
  const double correlation = information(0, 1) / std::sqrt(information(0, 0) * information(1, 1));
  EXPECT_NEAR(square(0, 1) / std::sqrt(square(0, 0) * square(1, 1)), correlation, 0.1);
}

// For a large network the traces come from samples.
TEST(VarianceScore, OfALargeNetworkIsSampled) {
  const NoisyChain chain(4, 150);
  const LinearizedNetwork linearized(chain.net);
  const Eigen::VectorXd share = chain.PositionShare(linearized);
  const VarianceScore score = ScoreVariances(Marginals(linearized), share);
  const Eigen::Index n = linearized.rows();
  const Eigen::MatrixXd M = Marginals(linearized).Project(Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd DMD = share.asDiagonal() * M * share.asDiagonal();
  EXPECT_NEAR(score.information(0, 0) / (0.5 * DMD.cwiseProduct(M).sum()), 1.0, 0.1);
  const Eigen::VectorXd r = M * linearized.residual();
  const double u = 0.5 * (r.dot(share.asDiagonal() * r) - (share.asDiagonal() * M).trace());
  EXPECT_NEAR(score.u[0], u, std::sqrt(score.information(0, 0)));
}

TEST(RestrictedLikelihood, WithoutUnknownsItIsTheLikelihood) {
  Network net;
  const auto x = net.AddVector<3>("x", Eigen::Vector3d::Zero());
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d(1.0, 2.0, 2.0), 1.0), x);
  net.Hold(x);
  const LinearizedNetwork linearized(net);
  const double ratio =
      ProfileVariance(linearized, Eigen::Vector3d::Ones(), {2.0}).log_likelihood_ratio[0];
  EXPECT_NEAR(ratio, -0.5 * (9.0 / 3.0 - 9.0 + 3.0 * std::log(3.0)), 1e-12);
}

TEST(RestrictedLikelihood, WhatCannotBeIsNamed) {
  const NoisyChain chain(1, 3);
  const LinearizedNetwork linearized(chain.net);
  const Eigen::VectorXd share = chain.PositionShare(linearized);
  EXPECT_THROW(ProfileVariance(linearized, share.head(4), {0.1}), InvalidInput);
  EXPECT_THROW(ProfileVariance(linearized, -share, {0.1}), InvalidInput);
  EXPECT_THROW(ProfileVariance(linearized, share, {-1.0}), InvalidInput);
  EXPECT_THROW(ProfileVariance(linearized, share, {std::nan("")}), InvalidInput);
  EXPECT_THROW(ScoreVariances(Marginals(linearized), share.head(4)), InvalidInput);
}

}  // namespace dn::solvers_test
