#include <dn/version.h>
#include <gtest/gtest.h>

#include <string>

namespace dn::core_test {

TEST(Version, IsTheSameAsTextAndInParts) {
  const std::string parts = std::to_string(DN_VERSION_MAJOR) + "." +
                            std::to_string(DN_VERSION_MINOR) + "." +
                            std::to_string(DN_VERSION_PATCH);
  EXPECT_EQ(kVersion, parts);
}

}  // namespace dn::core_test
