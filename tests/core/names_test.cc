#include <dn/names.h>
#include <gtest/gtest.h>

namespace dn::core_test {

TEST(NearestName, ByEditDistance) {
  EXPECT_EQ(NearestName("gyro_bias", {"acc_bias", "gyro_biases", "gnss"}), "gyro_biases");
  EXPECT_EQ(NearestName("kitten", {"mitten", "sitting"}), "mitten");
  EXPECT_EQ(NearestName("", {"long", "abc"}), "abc");
  EXPECT_EQ(NearestName("x", {}), "");
}

TEST(JoinNames, WithCommas) {
  EXPECT_EQ(JoinNames({}), "");
  EXPECT_EQ(JoinNames({"a"}), "a");
  EXPECT_EQ(JoinNames({"a", "b", "c"}), "a, b, c");
}

TEST(Names, ControlCharactersAreSeenAndBlanked) {
  for (const std::string& text : {std::string("a\nb"),
                                  std::string("a\x1b"
                                              "b"),
                                  std::string("a\x7f"
                                              "b"),
                                  std::string("a\0b", 3),
                                  std::string("a\xc2\x9b"
                                              "b")}) {
    EXPECT_TRUE(HasControls(text));
    EXPECT_EQ(WithoutControls(text), "a b");
  }
  for (const std::string text : {"", "lar 3 'x' `y` !", "Zürich", "\xc2\xa0"}) {
    EXPECT_FALSE(HasControls(text));
    EXPECT_EQ(WithoutControls(text), text);
  }
}

TEST(QuoteForShell, AsAShellReadsIt) {
  EXPECT_EQ(QuoteForShell("flights/lar-3_a.b"), "flights/lar-3_a.b");
  EXPECT_EQ(QuoteForShell(""), "''");
  EXPECT_EQ(QuoteForShell("my flight"), "'my flight'");
  EXPECT_EQ(QuoteForShell("$(touch x);`y`"), "'$(touch x);`y`'");
  EXPECT_EQ(QuoteForShell("it's"), "'it'\\''s'");
  EXPECT_EQ(QuoteForShell("~"), "'~'");
  EXPECT_EQ(QuoteForShell("a\n'\\b"), "$'a\\x0A\\x27\\x5Cb'");
}

}  // namespace dn::core_test
