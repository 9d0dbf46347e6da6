#pragma once

namespace dn::internal {

/// How often a stage at most takes new increments of the IMU for the biases that it has found.
inline constexpr int kMaxRelinearisations = 4;

}  // namespace dn::internal
