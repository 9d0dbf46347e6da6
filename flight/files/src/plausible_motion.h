#pragma once

namespace dn::files_internal {

/// Upper limit for the speed of a survey vehicle, m/s.
constexpr double kMostSpeedMps = 1000.0;
/// Length of one degree of latitude, m.
constexpr double kMetresPerDeg = 111000.0;

}  // namespace dn::files_internal
