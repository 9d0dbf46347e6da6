#pragma once

#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dn::testing {

/// Runs `action`, expects InvalidInput with a message that contains `what`, and returns its
/// location.
template <class Action>
FileLocation InvalidInputLocation(const Action& action, const std::string& what) {
  try {
    action();
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr(what));
    return e.where();
  }
  ADD_FAILURE() << "no InvalidInput, expected one with: " << what;
  return {};
}

/// Expects InvalidInput located on `line` (0: no line).
template <class Action>
void ExpectInvalid(const Action& action, const std::string& what, long line) {
  EXPECT_EQ(InvalidInputLocation(action, what).line, line) << what;
}

/// Expects InvalidInput located in a file whose path contains `file`.
template <class Action>
void ExpectInvalidIn(const Action& action, const std::string& what, const std::string& file) {
  EXPECT_THAT(InvalidInputLocation(action, what).file, ::testing::HasSubstr(file)) << what;
}

}  // namespace dn::testing
