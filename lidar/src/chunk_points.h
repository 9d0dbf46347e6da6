#pragma once

#include <cstddef>

namespace dn::lidar_internal {

/// Maximum number of points in a chunk of a StripReader.
inline constexpr std::size_t kChunkPoints = 65536;

}  // namespace dn::lidar_internal
