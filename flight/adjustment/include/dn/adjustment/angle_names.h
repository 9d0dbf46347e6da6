#pragma once

namespace dn {

/// Names of the boresight angles, in the order of the boresight's coordinates.
inline constexpr const char* kAngleNames[] = {"roll", "pitch", "yaw"};

}  // namespace dn
