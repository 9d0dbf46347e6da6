#include "shrinkage.h"

#include <gtest/gtest.h>

namespace dn::diagnosis_internal {

ReplicateTest Compared(double omnibus, double p) {
  ReplicateTest test;
  test.omnibus = omnibus;
  test.omnibus_mean = 40.0;
  test.p_omnibus = p;
  for (int k = -20; k <= 20; ++k) test.omnibus_of_replicates.push_back(40.0 + k);
  return test;
}

TEST(OmnibusShrinkage, IsTheShareOfTheExcessThatCloses) {
  const ReplicateTest before = Compared(240.0, 0.01), after = Compared(60.0, 0.03);
  const GapShrinkage shrinkage = OmnibusShrinkage({before, 0.0}, {after, 0.0});
  EXPECT_NEAR(shrinkage.fraction, 0.9, 1e-12);
  EXPECT_NEAR(shrinkage.interval_low, 1.0 - 39.0 / 200.0, 0.006);
  EXPECT_NEAR(shrinkage.interval_high, 1.0 - 1.0 / 200.0, 0.006);
}

// The chi-square of the locations and twice the evidence of outliers are on the same scale.
TEST(OmnibusShrinkage, CountsWhatTwinsCannotHave) {
  const ReplicateTest before = Compared(60.0, 0.03), after = Compared(60.0, 0.2);
  EXPECT_NEAR(OmnibusShrinkage({before, 90.0}, {after, 0.0}).fraction, 0.9, 1e-12);
  EXPECT_NEAR(OmnibusShrinkage({before, 90.0}, {after, 40.0}).fraction, 0.5, 1e-12);
}

TEST(OmnibusShrinkage, LocationsThatNeverDepartedAreClosed) {
  const ReplicateTest before = Compared(50.0, 0.2), after = Compared(55.0, 0.15);
  const GapShrinkage shrinkage = OmnibusShrinkage({before, 90.0}, {after, 0.0});
  EXPECT_EQ(shrinkage.fraction, 1.0);
  EXPECT_EQ(shrinkage.interval_high, 1.0);
}

}  // namespace dn::diagnosis_internal
