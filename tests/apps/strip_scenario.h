#pragma once

#include <gtest/gtest.h>

#include <string>

#include "run_program.h"

namespace dn::testing {

inline std::string With(std::string text, const std::string& old, const std::string& now) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), now);
}

/// Returns the short scenario with point clouds that are small enough for a test.
inline std::string StripScenario(const std::string& terrain) {
  std::string text = FileContent(ShortScenario());
  text = With(text, "[-400, 0, 400, 0, 200, 45]", "[-150, 0, 150, 0, 200, 40]");
  text = With(text, "[0, -400, 0, 400, 240, 45]", "[0, -150, 0, 150, 240, 40]");
  text = With(text, "kind: built_up", terrain);
  text = With(text, "gsd_m: 0.2", "gsd_m: 0.7\n  pulse_rate_hz: 14000");
  return text + "strips: true\n";
}

}  // namespace dn::testing
