#pragma once

#include <cstddef>

namespace dn::internal {

/// Points that a reader gives at a time, at most.
inline constexpr std::size_t kChunkPoints = 65536;

}  // namespace dn::internal
