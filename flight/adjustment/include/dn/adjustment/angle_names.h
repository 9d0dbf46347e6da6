#pragma once

namespace dn {

/// The angles of the boresight, in the order of its coordinates.
inline constexpr const char* kAngleNames[] = {"roll", "pitch", "yaw"};

}  // namespace dn
