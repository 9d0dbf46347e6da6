#pragma once

namespace dn::adjustment_internal {

/// Largest number of times that a stage integrates the IMU data again for changed biases.
inline constexpr int kMaxRepreintegrations = 4;

}  // namespace dn::adjustment_internal
