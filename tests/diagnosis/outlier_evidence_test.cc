#include "outlier_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace dn::diagnosis_internal {

struct Found {
  long number = 0;
  std::vector<double> lengths_m;
};

/// Draws measurements. A share of `all` has an error with a length uniform up to size_m. Errors
/// above a slightly varying threshold are found.
Found Draw(long all, double share, double size_m, double threshold_m, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Found found;
  for (long i = 0; i < all; ++i) {
    if (unit(*random) >= share) continue;
    const double length_m = size_m * unit(*random);
    if (length_m < threshold_m * (0.8 + 0.4 * unit(*random))) continue;
    ++found.number;
    found.lengths_m.push_back(length_m);
  }
  return found;
}

TEST(OutlierEvidence, TheShareHasThoseThatAreTooShortToBeFound) {
  constexpr double kShare = 0.06, kSize = 0.2;
  constexpr int kDraws = 400;
  std::mt19937 random(11);
  for (const double threshold_m : {0.02, 0.1}) {
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < kDraws; ++i) {
      const Found found = Draw(1000, kShare, kSize, threshold_m, &random);
      const HypothesisEvidence effect =
          OutlierEffect(EffectId::kGnssOutliers, found.number, 1000, 1e-3, found.lengths_m);
      const double z = (effect.estimate[0] - kShare) / effect.sigma[0];
      sum += z;
      squares += z * z;
      EXPECT_LE(std::abs(effect.estimate[1] - kSize), effect.sigma[1]);
    }
    EXPECT_NEAR(sum / kDraws, 0.0, 0.3) << threshold_m;
    EXPECT_NEAR(std::sqrt(squares / kDraws), 1.0, 0.25) << threshold_m;
  }
}

TEST(OutlierEvidence, ACoupleOfThemHasAWideSigma) {
  const HypothesisEvidence two = OutlierEffect(EffectId::kP2pOutliers, 2, 500, 1e-3, {0.8, 1.0});
  EXPECT_GT(two.estimate[0], 2.0 / 500.0);
  EXPECT_GT(two.sigma[0], 0.5 * two.estimate[0]);
  const HypothesisEvidence none = OutlierEffect(EffectId::kP2pOutliers, 0, 500, 1e-3, {});
  EXPECT_EQ(none.estimate[0], 0.0);
  EXPECT_GT(none.sigma[0], 0.0);
  EXPECT_LT(none.log_evidence, 0.0);
}

TEST(OutlierEvidence, ShortOnesAddTheirVariance) {
  constexpr double kShare = 0.1, kSigma = 0.02, kNorm = 5.0;
  constexpr int kAll = 400000;
  std::mt19937 random(12);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double size_m : {0.05, 0.4}) {
    double squares = 0.0;
    for (int i = 0; i < kAll; ++i) {
      const double length_m = unit(random) < kShare ? size_m * unit(random) : 0.0;
      if (length_m < kNorm * kSigma) squares += length_m * length_m;
    }
    const double per_axis = squares / kAll / 3.0 / (kSigma * kSigma);
    EXPECT_NEAR(ShortOutlierVariance(kShare, size_m, kSigma, kNorm), per_axis, 0.05 * per_axis);
  }
  EXPECT_EQ(ShortOutlierVariance(0.0, 0.0, kSigma, kNorm), 0.0);
}

}  // namespace dn::diagnosis_internal
