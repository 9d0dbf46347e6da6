#include "posterior.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dn::diagnosis_internal {

constexpr double kPosteriorRounding = 1e-12;

HypothesisEvidence Known(double nats, double statistic = 0.0) {
  HypothesisEvidence effect;
  effect.id = EffectId::kGnssLeverArm;
  effect.log_evidence = nats;
  effect.statistic = statistic;
  return effect;
}

HypothesisEvidence Nameless(double nats, double statistic = 0.0) {
  HypothesisEvidence discrepancy;
  discrepancy.log_evidence = nats;
  discrepancy.statistic = statistic;
  return discrepancy;
}

TEST(ComputePosterior, IsBayes) {
  const double nats = std::log(8.0);
  const HypothesisPosterior p = ComputePosterior({Known(nats), Known(0.0), Nameless(std::log(2.0))},
                                                 {.outside = 0.1, .unseen_nats = 3.0});
  // Something is present with probability 1/2: inside the library by 0.9, shared by two effects;
  // outside by 0.1, shared by three looks.
  const double inside = 0.45 / 2.0, outside = 0.05 / 3.0;
  const double own[] = {8.0 * inside, inside, 2.0 * outside};
  const double resembling[] = {8.0 * outside * 3.0 / (3.0 + nats), outside, 0.0};
  double sum = 0.5;
  for (int k = 0; k < 3; ++k) sum += own[k] + resembling[k];
  EXPECT_NEAR(p.nothing, 0.5 / sum, kPosteriorRounding);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(p.own[k], own[k] / sum, kPosteriorRounding);
    EXPECT_NEAR(p.resembling[k], resembling[k] / sum, kPosteriorRounding);
  }
  EXPECT_NEAR(p.outside, (resembling[0] + resembling[1] + own[2]) / sum, kPosteriorRounding);
}

TEST(ComputePosterior, OfHugeEvidenceStaysFinite) {
  const HypothesisPosterior p =
      ComputePosterior({Known(5000.0), Known(4900.0)}, {.outside = 0.2, .unseen_nats = 5.0});
  EXPECT_NEAR(p.own[0], 1.0, 1e-3);
  EXPECT_LT(p.own[1], 1e-40);
  EXPECT_EQ(p.nothing, 0.0);
}

TEST(ComputePosterior, GrowsWithEvidenceAndWithTrustInTheLibrary) {
  const auto named = [](double nats, double outside) {
    return ComputePosterior({Known(nats), Nameless(0.0)}, {.outside = outside, .unseen_nats = 5.0})
        .own[0];
  };
  EXPECT_GT(named(100.0, 0.2), named(20.0, 0.2));
  EXPECT_GT(named(100.0, 0.1), named(100.0, 0.4));
  EXPECT_EQ(named(1000.0, 0.0), 1.0) << "nothing is outside";
}

TEST(ComputePosterior, ARestMakesEveryNameDoubtful) {
  const HypothesisPrior with_rest{.outside = 0.2, .unseen_nats = 5.0, .rest_nats = 8.0};
  const HypothesisPosterior p = ComputePosterior({Known(500.0), Nameless(0.0)}, with_rest);
  // The name and a second event outside: 0.8 times 0.2. One event outside that looks like either of
  // two hypotheses: 0.2 / 2.
  EXPECT_NEAR(p.own[0], 0.16 / 0.26, 1e-6);
  EXPECT_NEAR(p.outside, 1.0, 1e-6);
  EXPECT_NEAR(DifferingShare(with_rest, 72.0), 0.1, kPosteriorRounding);
}

TEST(ComputePosterior, ADiscrepancyThatFitsNoBetterHasNoMoreEvidence) {
  const HypothesisPrior prior{.outside = 0.2, .unseen_nats = 5.0};
  const auto name = [&](double statistic_of_discrepancy) {
    return ComputePosterior({Known(30.0, 100.0), Nameless(300.0, statistic_of_discrepancy)}, prior)
        .own[0];
  };
  EXPECT_GT(name(99.0), 0.8);
  EXPECT_LT(name(700.0), 1e-6);
}

}  // namespace dn::diagnosis_internal
