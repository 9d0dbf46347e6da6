#include "process_mixture.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>

namespace dn::diagnosis_test {

using diagnosis_internal::MixProcess;
using diagnosis_internal::ProcessMixture;
using diagnosis_internal::ProcessShape;
using diagnosis_internal::ProcessSize;
using diagnosis_internal::SizeSource;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Coefficients of a process in a network: their information, and what they shift.
struct Coefficients {
  static constexpr Index kSize = 40;
  MatrixXd A, shift = MatrixXd::Random(3, kSize);
  std::vector<ProcessSize> sizes;
  std::vector<ProcessShape> shapes;
  std::mt19937 random{7};
  std::normal_distribution<double> normal;

  explicit Coefficients(double information = 2.0) {
    const MatrixXd L = MatrixXd::Random(3 * kSize, kSize);
    A = information * L.transpose() * L;
    double sum = 0.0;
    for (int k = -6; k <= 6; ++k) sum += std::exp(-0.5 * k * k / 4.0);
    for (int k = -6; k <= 6; ++k) {
      sizes.push_back({0.3 * std::exp(0.35 * k), -0.5 * k * k / 4.0 - std::log(sum)});
    }
    for (const double decay : {0.02, 0.1, 0.4}) {
      ProcessShape shape{1.0 / decay, VectorXd(kSize), -std::log(3.0)};
      for (Index k = 0; k < kSize; ++k) shape.sigma[k] = std::exp(-decay * double(k));
      shapes.push_back(shape);
    }
  }

  VectorXd Normals(Index n) {
    return VectorXd::NullaryExpr(n, [&] { return normal(random); });
  }
  /// Draws coefficients, and returns their scores.
  VectorXd Score(double size, const ProcessShape& shape, VectorXd* e) {
    *e = size * shape.sigma.cwiseProduct(Normals(kSize));
    return -A * *e + A.llt().matrixL() * Normals(kSize);
  }
  template <class Choice>
  const Choice& Draw(const std::vector<Choice>& choices) {
    double u = std::uniform_real_distribution<double>()(random);
    for (const Choice& one : choices) {
      u -= std::exp(one.log_probability);
      if (u < 0.0) return one;
    }
    return choices.back();
  }
};

TEST(ProcessMixture, OneSizeAndShapeIsAGaussianPrior) {
  Coefficients of;
  VectorXd e;
  const VectorXd s = of.Score(0.3, of.shapes[1], &e);
  const ProcessMixture mixture = MixProcess(s, of.A, {{0.3, 0.0}}, {of.shapes[1]});
  MatrixXd N = of.A;
  N.diagonal() += (0.3 * of.shapes[1].sigma).cwiseAbs2().cwiseInverse();
  const MatrixXd P = N.inverse();
  EXPECT_LT((mixture.covariance - P).norm(), 1e-10 * P.norm());
  EXPECT_LT((mixture.mean + P * s).norm(), 1e-10 * mixture.mean.norm());
  EXPECT_LT((mixture.prior_sigma - 0.3 * of.shapes[1].sigma).norm(), 1e-12);
}

TEST(ProcessMixture, TheEvidencePeaksAtTheSizeAndShapeOfASimulatedProcess) {
  Coefficients of(100.0);
  for (const double size : {0.1, 0.3, 0.9}) {
    double log_size = 0.0, tau_s = 0.0;
    constexpr int kDraws = 50;
    for (int k = 0; k < kDraws; ++k) {
      VectorXd e;
      const VectorXd s = of.Score(size, of.shapes[0], &e);
      const ProcessMixture mixture = MixProcess(s, of.A, of.sizes, of.shapes);
      log_size += mixture.log_size.mean / kDraws;
      tau_s += mixture.tau_s.mean / kDraws;
    }
    EXPECT_NEAR(log_size, std::log(size), 0.1) << size;
    EXPECT_NEAR(tau_s, of.shapes[0].tau_s, 0.1 * of.shapes[0].tau_s) << size;
  }
}

// Squared errors of a posterior mean over its covariance have a mean of exactly one per dimension.
// Sizes and shapes must be drawn from their priors.
TEST(ProcessMixture, CovarianceIsThatOfTheErrorsOverManyDraws) {
  Coefficients of;
  constexpr int kDraws = 1000;
  double sum = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    VectorXd e;
    const double size = of.Draw(of.sizes).size;
    const VectorXd s = of.Score(size, of.Draw(of.shapes), &e);
    const ProcessMixture mixture = MixProcess(s, of.A, of.sizes, of.shapes);
    const Eigen::Vector3d error = of.shift * (e - mixture.mean);
    const Eigen::Matrix3d C = of.shift * mixture.covariance * of.shift.transpose();
    sum += error.dot(C.llt().solve(error));
  }
  // 99.9 % of a chi-square with 3000 degrees of freedom, over its mean.
  EXPECT_NEAR(sum / (3.0 * kDraws), 1.0, 3.29 * std::sqrt(2.0 / (3.0 * kDraws)));
}

TEST(ProcessMixture, WithoutMeasuredValuesThePriorWeighs) {
  Coefficients of;
  const ProcessMixture mixture = MixProcess(VectorXd::Zero(Coefficients::kSize), of.A, of.sizes,
                                            of.shapes, SizeSource::kPrior);
  EXPECT_NEAR(mixture.log_size.mean, std::log(0.3), 1e-9);
  EXPECT_NEAR(mixture.size.mean, mixture.size_before.mean, 0.02 * mixture.size.mean);
  EXPECT_EQ(mixture.mean.norm(), 0.0);
}

}  // namespace dn::diagnosis_test
