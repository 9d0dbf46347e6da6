#pragma once

#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dn::testing {

/// Runs `action` and expects InvalidInput whose message contains `what`, found on `line` (0: no
/// line is named).
template <class Action>
void ExpectInvalid(const Action& action, const std::string& what, long line) {
  try {
    action();
    ADD_FAILURE() << "no InvalidInput, expected one with: " << what;
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr(what));
    EXPECT_EQ(e.where().line, line) << e.what();
  }
}

}  // namespace dn::testing
