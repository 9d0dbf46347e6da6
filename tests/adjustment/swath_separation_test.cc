#include <dn/adjustment/swath_separation.h>
#include <gtest/gtest.h>

namespace dn::adjustment_test {

TEST(SwathSeparation, CountsHeightsOfBothSigns) {
  SwathSeparation separation;
  for (const double up_m : {0.02, -0.04, 0.07, -0.09, 0.15, 0.15, -0.17, 3.0}) {
    separation.Add(up_m);
  }
  const Json shares = separation.ToJson();
  EXPECT_EQ(shares["within_3_cm"], 1.0 / 8.0);
  EXPECT_EQ(shares["within_5_cm"], 2.0 / 8.0);
  EXPECT_EQ(shares["to_8_cm"], 3.0 / 8.0);
  EXPECT_EQ(shares["within_10_cm"], 4.0 / 8.0);
  EXPECT_EQ(shares["8_to_16_cm"], 3.0 / 8.0);
  EXPECT_EQ(shares["above_16_cm"], 2.0 / 8.0);
}

// A limit belongs to the better class.
TEST(SwathSeparation, ItsLimitsAreIncluded) {
  SwathSeparation separation;
  separation.Add(0.08);
  EXPECT_EQ(separation.ToJson()["to_8_cm"], 1.0);
}

}  // namespace dn::adjustment_test
