#pragma once

namespace dn::files_internal {

/// Sizes of one count of the increments in a RAWIMU message, from the manual of the receiver.
struct ImuCounts {
  const char* sensors;
  double angle_rad, velocity_mps;
};

/// Returns the sensor whose counts give gravity for a mean force [counts/s]; nullptr if there is
/// none. The sizes of different sensors are at least a fifth apart.
const ImuCounts* FindImuCounts(double mean_force);

}  // namespace dn::files_internal
