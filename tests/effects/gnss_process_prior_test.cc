#include <dn/effects/gnss_process_prior.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::effects_test {

TEST(GnssProcessPrior, SizesHaveTheLogNormalDistributionThatTheHeaderStates) {
  double sum = 0.0, mean = 0.0, square = 0.0, last = 0.0;
  for (const GnssProcessPrior::Size& one : GnssProcessPrior::Sizes()) {
    EXPECT_GT(one.size, last);
    last = one.size;
    const double p = std::exp(one.log_probability), log_size = std::log(one.size);
    sum += p;
    mean += p * log_size;
    square += p * log_size * log_size;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_NEAR(std::exp(mean), GnssProcessPrior::kMedianSize, 1e-12);
  EXPECT_NEAR(std::sqrt(square - mean * mean), GnssProcessPrior::kLogSizeSigma, 1e-3);
}

TEST(GnssProcessPrior, TimeConstantsLieWithinHalfTheFlight) {
  EXPECT_EQ(GnssProcessPrior::TausS(10.0), std::vector<double>{GnssProcessPrior::kShortestTauS});
  EXPECT_EQ(GnssProcessPrior::TausS(200.0).size(), 2U);
  const std::vector<double> taus_s = GnssProcessPrior::TausS(1e5);
  EXPECT_NEAR(taus_s.back(), GnssProcessPrior::kLongestTauS, 1.0);
}

TEST(GnssProcessPrior, SizesAreRelativeToTheHorizontalSigma) {
  EXPECT_DOUBLE_EQ(GnssProcessPrior::StatedSigma({0.015, 0.015, 0.03}), 0.015);
}

}  // namespace dn::effects_test
