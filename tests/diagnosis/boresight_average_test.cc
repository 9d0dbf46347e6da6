#include "boresight_average.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dn::diagnosis_internal {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMicro = 1e-6;
// Angles are of some microradians; second orders of rotations are far below.
constexpr double kTolerance = 1e-15;

BoresightEstimate At(double roll, double sigma) {
  return {kMicro * Vector3d(roll, 0.0, 0.0),
          kMicro * kMicro * sigma * sigma * Matrix3d::Identity()};
}

HypothesisEvidence Moving(const std::string& name, double nats, const BoresightEstimate& with,
                          const BoresightEstimate& without) {
  HypothesisEvidence effect;
  effect.name = name;
  effect.id = EffectId::kLidarTimeOffset;
  effect.log_evidence = nats;
  effect.boresight = {with, without};
  return effect;
}

constexpr HypothesisPrior kOnlyTheLibrary{.outside = 0.0, .unseen_nats = 5.0};

TEST(AverageBoresight, WeighsNoEffectAgainstOne) {
  const BoresightEstimate base = At(0.0, 1.0);
  // Equal weights: priors 1/2 and 1/2, evidence 0.
  const CompetingHypotheses further =
      MakeCompetingHypotheses("", {Moving("a", 0.0, At(4.0, 2.0), base)}, kOnlyTheLibrary);
  const BoresightEstimate mean = AverageBoresight(base, {}, further);
  EXPECT_NEAR(mean.angles_rad.x(), kMicro * 2.0, kTolerance);
  // Within: (1 + 4) / 2. Between: 2^2, in roll alone.
  EXPECT_NEAR(mean.sigma_rad().x(), kMicro * std::sqrt(2.5 + 4.0), kTolerance);
  EXPECT_NEAR(mean.sigma_rad().y(), kMicro * std::sqrt(2.5), kTolerance);
}

TEST(AverageBoresight, OfACertainNameIsThatOfItsFit) {
  const BoresightEstimate base = At(0.0, 1.0), refit = At(7.0, 1.5);
  const CompetingHypotheses set = MakeCompetingHypotheses(
      "a", {Moving("a", 200.0, At(6.5, 1.4), base), Moving("b", 100.0, At(90.0, 1.0), base)},
      kOnlyTheLibrary);
  const BoresightEstimate mean = AverageBoresight(refit, {set}, {});
  EXPECT_NEAR(mean.angles_rad.x(), kMicro * 7.0, kTolerance);
  EXPECT_NEAR(mean.sigma_rad().x(), kMicro * 1.5, kTolerance);
}

// The alternative is as far from the refit as it is from the name to first order.
TEST(AverageBoresight, OfATieLiesBetweenItsMembers) {
  const BoresightEstimate base = At(0.0, 1.0), refit = At(7.0, 1.5);
  const CompetingHypotheses set = MakeCompetingHypotheses(
      "a", {Moving("a", 200.0, At(6.5, 1.5), base), Moving("b", 200.0, At(10.5, 1.5), base)},
      kOnlyTheLibrary);
  const BoresightEstimate mean = AverageBoresight(refit, {set}, {});
  EXPECT_NEAR(mean.angles_rad.x(), kMicro * 9.0, kTolerance);
  EXPECT_NEAR(mean.sigma_rad().x(), kMicro * std::hypot(1.5, 2.0), kTolerance);
}

TEST(AverageBoresight, OfARestContainsTheShiftOfWhatMayResembleTheName) {
  const BoresightEstimate base = At(0.0, 1.0), refit = At(6.0, 1.0);
  const std::vector<HypothesisEvidence> competing{Moving("a", 60.0, At(6.0, 1.0), base)};
  const HypothesisPrior alone{.outside = 0.2, .unseen_nats = 5.0};
  HypothesisPrior with_rest = alone;
  with_rest.rest_nats = 20.0;
  const auto sigma = [&](const HypothesisPrior& prior) {
    return AverageBoresight(refit, {MakeCompetingHypotheses("a", competing, prior)}, {})
        .sigma_rad()
        .x();
  };
  EXPECT_LT(sigma(alone), kMicro * 1.05);
  // Weights 0.16 and 0.2; the share of the shift that differs is 20 / 80.
  EXPECT_NEAR(sigma(with_rest), kMicro * std::sqrt(1.0 + 0.2 / 0.36 * 36.0 / 4.0), 1e-9);
}

TEST(AverageBoresight, OfADiscrepancyUsesItsShift) {
  const BoresightEstimate base = At(0.0, 1.0);
  HypothesisEvidence strips = Moving("strips", 50.0, At(5.0, 3.0), base);
  strips.id.reset();
  const BoresightEstimate mean = AverageBoresight(
      base, {}, MakeCompetingHypotheses("", {strips}, {.outside = 0.2, .unseen_nats = 5.0}));
  EXPECT_NEAR(mean.angles_rad.x(), kMicro * 5.0, kTolerance);
  EXPECT_NEAR(mean.sigma_rad().x(), kMicro * 3.0, kTolerance);
}

// The square of the shift is 1e18 times the variance.
TEST(AverageBoresight, OfALargeShiftKeepsItsSigma) {
  const BoresightEstimate base = At(0.0, 1.0);
  const BoresightEstimate mean = AverageBoresight(
      base, {},
      MakeCompetingHypotheses("", {Moving("a", 500.0, At(1e5, 1e-4), base)}, kOnlyTheLibrary));
  EXPECT_NEAR(mean.sigma_rad().x(), kMicro * 1e-4, kMicro * 1e-9);
}

TEST(Moments, AverageOverSizes) {
  // One component with so much information that the prior of its size does not count.
  const SizeAveragedEvidence sharp(Eigen::MatrixXd::Constant(1, 1, 1e8),
                                   Eigen::VectorXd::Constant(1, 1.0));
  const LinearMoments known =
      sharp.Moments(Eigen::VectorXd::Constant(1, -2e8), Eigen::MatrixXd::Constant(1, 1, 3.0));
  EXPECT_NEAR(known.mean[0], 6.0, 1e-6);
  EXPECT_NEAR(known.covariance(0, 0), 9e-8, 1e-11);
  // Without information the variance is the mean of the prior variances.
  const SizeAveragedEvidence blind(Eigen::MatrixXd::Zero(1, 1), Eigen::VectorXd::Constant(1, 2.0));
  const LinearMoments unknown =
      blind.Moments(Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Constant(1, 1, 1.0));
  EXPECT_EQ(unknown.mean[0], 0.0);
  EXPECT_NEAR(unknown.covariance(0, 0), 4.0 * (0.1 * 0.01 + 0.2 * 0.1 + 0.4 + 0.2 * 10.0 + 10.0),
              1e-9);
}

}  // namespace dn::diagnosis_internal
