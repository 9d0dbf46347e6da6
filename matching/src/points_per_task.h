#pragma once

#include <cstddef>

namespace dn::internal {

/// Points that one task of a thread works on.
inline constexpr std::size_t kPointsPerTask = 4096;

}  // namespace dn::internal
