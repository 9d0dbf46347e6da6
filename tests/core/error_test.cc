#include <dn/error.h>
#include <dn/interrupted.h>
#include <gtest/gtest.h>

namespace dn::core_test {

template <class Exception, class... Arguments>
bool IsCaughtAsError(const Arguments&... arguments) {
  try {
    throw Exception(arguments...);
  } catch (const Error&) {
    return true;
  } catch (...) {
    return false;
  }
}

TEST(Error, IsTheBaseOfEveryException) {
  EXPECT_TRUE(IsCaughtAsError<InvalidInput>("a"));
  EXPECT_TRUE(IsCaughtAsError<InvalidConfig>("a"));
  EXPECT_TRUE(IsCaughtAsError<RankDeficient>("a"));
  EXPECT_TRUE(IsCaughtAsError<Interrupted>());
}

}  // namespace dn::core_test
