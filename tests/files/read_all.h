#pragma once

#include <dn/lidar/strip_io.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace dn::testing {

/// Returns the first batch of points of a strip.
inline StripCloud ReadAll(const std::filesystem::path& file) {
  StripCloud points;
  EXPECT_TRUE(OpenStrip(file)->Next(&points));
  return points;
}

}  // namespace dn::testing
