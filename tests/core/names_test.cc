#include <dn/names.h>
#include <gtest/gtest.h>

namespace dn {
namespace {

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

}  // namespace
}  // namespace dn
