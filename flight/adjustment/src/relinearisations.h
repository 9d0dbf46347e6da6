#pragma once

namespace dn::internal {

/// Largest number of times that a stage integrates the IMU data again for changed biases.
inline constexpr int kMaxRepreintegrations = 4;

}  // namespace dn::internal
