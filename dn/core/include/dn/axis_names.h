#pragma once

#include <string>
#include <vector>

namespace dn {

// Names of three components, in the order of the coordinates.
inline constexpr const char* kXyz[] = {"x", "y", "z"};
inline constexpr const char* kEnu[] = {"east", "north", "up"};
inline constexpr const char* kRollPitchYaw[] = {"roll", "pitch", "yaw"};        ///< boresight
inline constexpr const char* kAttitudeAngles[] = {"roll", "pitch", "heading"};  ///< attitude

/// Returns three names as a list of strings.
inline std::vector<std::string> AxisNames(const char* const (&names)[3]) {
  return {names, names + 3};
}

}  // namespace dn
