#pragma once

#include <dn/lidar/strip_cloud.h>

#include <cstddef>
#include <cstdint>
#include <set>

namespace dn {

/// Selects the points of a strip that are used.
struct PointFilter {
  /// Uses only the last return of each pulse. Last returns under trees come from the same ground
  /// from every side; returns from tree crowns and roof edges do not.
  bool last_returns = false;
  /// LAS classes, such as 2 for ground; empty: all classes but noise (7 and 18).
  std::set<std::uint8_t> classes;
};

/// Returns the reason why point `i` is not used; nullptr if it is used. Withheld and synthetic
/// points are never used. In a file without return
/// numbers every return is a last one. In a file without classes no point belongs to a class.
const char* DropReason(const PointFilter& filter, const StripCloud& points, std::size_t i);

}  // namespace dn
