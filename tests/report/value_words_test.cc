#include <dn/report/value_words.h>
#include <gtest/gtest.h>

#include <limits>

namespace dn::report_test {

TEST(FormatWithSigma, RoundsBothToTheSecondDigitOfTheSigma) {
  EXPECT_EQ(FormatWithSigma(46.8123, 1.234), "46.8 +- 1.2");
  EXPECT_EQ(FormatWithSigma(46.8, 10.0), "47 +- 10");
  EXPECT_EQ(FormatWithSigma(243301.06900000002, 0.004), "243301.069 +- 0.004");
  EXPECT_EQ(FormatWithSigma(-0.00012346, 0.0000056), "-0.0001235 +- 0.0000056");
}

TEST(FormatWithSigma, LargeNumbersHaveNoExponent) {
  EXPECT_EQ(FormatWithSigma(56789.0, 1234.0), "56800 +- 1200");
  EXPECT_EQ(FormatWithSigma(-3.0, 45678.0), "0 +- 46000");
}

TEST(FormatWithSigma, ZerosAtTheEndAreLeftOut) {
  EXPECT_EQ(FormatWithSigma(20.0, 0.5), "20 +- 0.5");
  EXPECT_EQ(FormatWithSigma(-0.0001, 0.5), "0 +- 0.5");
}

TEST(FormatWithSigma, ASigmaThatIsNoneLeavesTheValueAsItIs) {
  EXPECT_EQ(FormatWithSigma(1.5, 0.0), "1.5 +- 0");
  EXPECT_EQ(FormatWithSigma(1.5, std::numeric_limits<double>::infinity()), "1.5 +- inf");
}

}  // namespace dn::report_test
