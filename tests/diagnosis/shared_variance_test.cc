#include "shared_variance.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

namespace dn::diagnosis_test {

using diagnosis_internal::ClusterSums;
using diagnosis_internal::EstimateSharedVariance;
using diagnosis_internal::PosteriorNoiseSigma;
using diagnosis_internal::PosteriorNoiseVariance;
using diagnosis_internal::SharedVariance;
using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kSharedRows = 3000;
// Rows per cluster of each division, and lengths that name the divisions.
const std::vector<Index> kWidths = {2, 5, 20};
const std::vector<double> kLengths_m = {10.0, 20.0, 40.0};

/// Returns residuals with white noise, and errors of these variances that `width` rows share.
VectorXd DrawResiduals(double white, double shared, Index width, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  VectorXd r(kSharedRows);
  double common = 0.0;
  for (Index k = 0; k < kSharedRows; ++k) {
    if (k % width == 0) common = std::sqrt(shared) * normal(random);
    r[k] = std::sqrt(white) * normal(random) + common;
  }
  return r;
}

SharedVariance EstimateShared(const VectorXd& r) {
  std::vector<ClusterSums> divisions;
  for (const Index width : kWidths) {
    ClusterSums sums;
    sums.count = VectorXd::Constant(kSharedRows / width, static_cast<double>(width));
    sums.energy = r.reshaped(width, kSharedRows / width).colwise().sum().cwiseAbs2().transpose();
    divisions.push_back(sums);
  }
  return EstimateSharedVariance(divisions, kLengths_m, r.squaredNorm(), kSharedRows);
}

TEST(SharedVariance, WhiteNoiseOfAnySizeSharesNothing) {
  for (const double white : {0.8, 1.0, 1.9}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const SharedVariance posterior = EstimateShared(DrawResiduals(white, 0.0, 1, seed));
      EXPECT_LT(posterior.total_shared(), 0.02 * white) << seed;
      EXPECT_NEAR(posterior.white / white, 1.0, 0.15) << seed;
    }
  }
}

TEST(SharedVariance, FindsSizeAndLength) {
  for (const double shared : {0.1, 0.5}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(seed);
      const SharedVariance posterior =
          EstimateShared(DrawResiduals(1.0 - shared, shared, 20, seed));
      EXPECT_GT(posterior.probability, 0.999);
      EXPECT_NEAR(posterior.length_m, 40.0, 1.0);
      // 150 clusters: the sizes of the grid are a factor of two apart.
      EXPECT_NEAR(posterior.total_shared() / shared, 1.0, 0.5);
      EXPECT_NEAR(posterior.white, 1.0 - shared, 0.1);
    }
  }
}

/// Returns the posterior for clusters of 20 rows. Their sums have a part of the degrees of freedom.
SharedVariance EstimateDependent(const VectorXd& r, double independent) {
  ClusterSums sums;
  sums.count = VectorXd::Constant(150, 20.0);
  sums.energy = r.reshaped(20, 150).colwise().sum().cwiseAbs2().transpose();
  sums.independent = independent;
  return EstimateSharedVariance({sums}, {1.0}, r.squaredNorm(), kSharedRows);
}

// Sums that are not independent have less evidence: the posterior is wider.
TEST(SharedVariance, DependentSumsCountLess) {
  const VectorXd white = DrawResiduals(1.0, 0.0, 20, 3);
  EXPECT_LT(EstimateDependent(white, 1.0).total_shared(),
            EstimateDependent(white, 0.2).total_shared());
  const VectorXd shared = DrawResiduals(0.9, 0.1, 20, 3);
  EXPECT_LT(EstimateDependent(shared, 1.0).size_sigma, EstimateDependent(shared, 0.2).size_sigma);
}

TEST(NoiseVariance, StaysWithThePriorWithoutDataAndFollowsManyData) {
  EXPECT_EQ(PosteriorNoiseVariance(5.0, 0.0), 1.0);
  EXPECT_NEAR(PosteriorNoiseSigma(1.0, 0.0), 0.354, 1e-3);
  EXPECT_NEAR(PosteriorNoiseVariance(1.9, 9000.0), 1.9, 2e-3);
  EXPECT_NEAR(PosteriorNoiseSigma(1.9, 9000.0), 1.9 * std::sqrt(2.0 / 9000.0), 1e-3);
  EXPECT_NEAR(PosteriorNoiseVariance(2.0, 18.0), 1.5, 1e-12);
}

}  // namespace dn::diagnosis_test
