#pragma once

#include <dn/lidar/strip_cloud.h>

#include <cstddef>
#include <cstdint>
#include <set>

namespace dn {

/// Which points of a strip are used.
struct PointFilter {
  /// Only the last return of each pulse: what lies under trees is the same ground from every side,
  /// crowns and edges of roofs are not.
  bool last_returns = false;
  std::set<std::uint8_t> classes;  ///< LAS classes, as 2 for ground; empty: all
};

/// Why a point of the cloud is not used; nullptr: it is. A file without returns has last ones only,
/// one without classes no class.
const char* WhyDropped(const PointFilter& filter, const StripCloud& points, std::size_t i);

}  // namespace dn
